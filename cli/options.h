// Call holds the command that a command line chooses, with its options. options.cpp alone includes the parser
// library.
#pragma once

#include <functional>
#include <span>
#include <string>

#include "cli/commands.h"

namespace firn {

struct Call {
  std::string command;       ///< "config check": for messages; "" before a command is known
  std::function<int()> run;  ///< returns an ExitCode; throws UsageError, ConfigError, std::exception
};

/// --help and --version print to stdout and give a call that returns 0; a usage error gives a call that
/// throws UsageError naming the argument and, for an unknown command, the nearest known one.
Call parse_command_line(std::span<const Command> commands, int argc, const char* const* argv);

}  // namespace firn
