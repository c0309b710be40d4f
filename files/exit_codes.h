// What every command of firn returns to the shell.
#pragma once

#include <stdexcept>

namespace firn {

enum ExitCode : int {
  kOk = 0,
  kFailed = 1,         ///< the run failed, or the comparison differs
  kUsage = 2,          ///< usage or configuration
  kSafetyStop = 3,     ///< an instrument's fault or a safety stop
  kInterrupted = 130,  ///< Ctrl-C; the lab was made safe first
};

/// Anything wrong with what the user typed or handed in: exit code 2.
struct UsageError : std::runtime_error {
  using runtime_error::runtime_error;
};

}  // namespace firn
