// Command holds one subcommand of firn: its name, its line in the help text, its arguments and examples of
// its use.
#pragma once

#include <array>

namespace firn {

class OptionSet;

/// A command line as a reader gives it, "firn print part.toml", and its purpose.
struct Example {
  const char* line = "";
  const char* purpose = "";
};

struct Command {
  const char* name;
  const char* summary;
  void (*declare)(OptionSet& options);
  const char* group = "More";         ///< heading in the help text: its user's task
  std::array<Example, 3> examples{};  ///< an empty line ends them
};

}  // namespace firn
