// Command line -> the chosen command with its options. The only place that knows the parser library.
#pragma once

#include <functional>
#include <string>

namespace firn {

struct Call {
  std::string command;       ///< "config check": for messages; "" before a command is known
  std::function<int()> run;  ///< returns an ExitCode; throws UsageError, ConfigError, std::exception
};

/// --help and --version print to stdout and give a call that returns 0; a usage error gives a call that
/// throws UsageError naming the argument and, for an unknown command, the nearest known one.
Call parse_command_line(int argc, const char* const* argv);

}  // namespace firn
