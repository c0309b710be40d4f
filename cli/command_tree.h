// CommandTree describes the commands of the program and their options, as documents for shells and readers
// are written from it.
#pragma once

#include <string>
#include <vector>

namespace firn {

struct DescribedOption {
  std::vector<std::string> names;    ///< "--output", "-o"; of an argument without dashes its name, "RUN"
  std::string help;                  ///< one sentence
  std::string value;                 ///< what it takes, "TEXT"; empty: nothing, it is a flag
  std::vector<std::string> choices;  ///< of the value; empty: any
  bool positional = false, required = false, many = false;
};

struct CommandTree {
  std::string name, summary;
  std::string group;     ///< heading under which help texts list it
  std::string examples;  ///< the end of its help text: "Examples:", then two lines each; "" without any
  std::vector<DescribedOption> options;
  std::vector<CommandTree> subcommands;
};

/// Returns a script that completes the program's words in a shell.
/// @param shell "bash", "zsh" or "fish". @throws std::invalid_argument: another one
std::string completion_script(const CommandTree& program, const std::string& shell);

/// A page of the manual, as man(1) shows it.
struct ManPage {
  std::string name;  ///< "firn-print"
  std::string roff;
};
/// Returns a page of the program and one of each command, subcommands among its own words.
/// @param version of the program, for the foot of the pages
std::vector<ManPage> man_pages(const CommandTree& program, const std::string& version);

}  // namespace firn
