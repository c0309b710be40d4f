// OwnProgram is one of the lab's own programs that a print starts beside Firn's processes: [nodes.NAME]
// with a command. docs/own-lcm-program.md
#pragma once

#include <map>
#include <string>
#include <string_view>

namespace firn {

struct OwnProgram {
  std::string command;             ///< for /bin/sh, in the folder where firn print was called
  std::string needed;              ///< "off": the print goes on without it; "on" or empty: it stops
  double longest_silence_s = 0.0;  ///< wall time without a message of it; 0 = it may be silent

  bool is_needed() const { return needed != "off"; }
};

/// By name, in its order.
using OwnPrograms = std::map<std::string, OwnProgram>;

/// Returns true for 1 to 24 of a-z, 0-9, '_', '-' that no process of Firn is called by: the name by which a
/// program of the lab's own speaks.
bool is_own_name(std::string_view name);

inline constexpr const char* kOwnNameForm =
    "1 to 24 of a-z, 0-9, '_' and '-', and no name of a process of Firn";

/// Returns the name in "own:NAME", the value of a key that takes the word of such a program; of another value
/// an empty text.
std::string_view own_source(std::string_view value);

}  // namespace firn
