// Command holds one subcommand of firn: its name, its line in the help text and its arguments.
#pragma once

#include <span>

namespace firn {

class OptionSet;

struct Command {
  const char* name;
  const char* summary;
  void (*declare)(OptionSet& options);
};

/// All commands of the program in the order of the help text: commands.cpp of firn, demo_commands.cpp of
/// firn-demo.
std::span<const Command> commands();

}  // namespace firn
