// ExitCode holds the exit codes of the firn program, as every command returns them to the shell.
#pragma once

namespace firn {

enum ExitCode : int {
  kOk = 0,
  kFailed = 1,          ///< the run failed, or the comparison differs
  kUsage = 2,           ///< usage or configuration
  kSafetyStop = 3,      ///< an instrument's fault or a safety stop
  kOutOfTolerance = 4,  ///< the print ran to its end, but the part is not as wanted
  kInterrupted = 130,   ///< Ctrl-C; the lab was made safe first
};

}  // namespace firn
