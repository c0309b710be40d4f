// Command holds one subcommand of firn: its name, its line in the help text and its arguments.
#pragma once

namespace firn {

class OptionSet;

struct Command {
  const char* name;
  const char* summary;
  void (*declare)(OptionSet& options);
};

}  // namespace firn
