// Failure is how a command ended that threw: the one line for the user, and the exit code.
#pragma once

#include <exception>
#include <string>

namespace firn {

struct Failure {
  int code = 1;
  std::string line;  ///< names file, key or byte, and the cause; no line breaks
};

/// @returns kUsage for what the user named or gave: an argument, a configuration, a file that is missing, of
/// another kind or not allowed; kFailed for the rest, as a full disk or too little memory
Failure failure_of(const std::exception& error);

}  // namespace firn
