// Call holds the command that a command line chooses, with its options. options.cpp alone includes the parser
// library.
#pragma once

#include <functional>
#include <span>
#include <string>

#include "cli/command.h"
#include "print/labs/product.h"

namespace firn {

struct Call {
  std::string command;       ///< "config check": for messages; "" before a command is known
  std::function<int()> run;  ///< returns an ExitCode; throws UsageError, ConfigError, std::exception
  std::string problem;       ///< of a usage error, which run() throws; else ""
};

/// @param product handed to the command; outlives the call
/// --help, --version and nothing at all print to stdout and give a call that returns 0; a usage error gives a
/// call that throws UsageError naming the argument and, for an unknown command, the nearest known one.
Call parse_command_line(std::span<const Command> commands, const Product& product, int argc,
                        const char* const* argv);

}  // namespace firn
