#include <fmt/core.h>

#include <algorithm>

#include "cli/command_tree.h"

namespace firn {
namespace {

// Text of a paragraph: no character of it is a request or an escape.
std::string roff(const std::string& text) {
  std::string all = text.starts_with(".") || text.starts_with("'") ? "\\&" : "";
  for (const char c : text) {
    if (c == '\\')
      all += "\\e";
    else if (c == '-')
      all += "\\-";
    else
      all += c;
  }
  return all;
}

std::string synopsis(const std::string& command, const CommandTree& c) {
  std::string text = ".B " + roff(command) + "\n";
  if (!c.subcommands.empty()) text += ".I COMMAND\n";
  for (const DescribedOption& o : c.options)
    if (o.positional)
      text += fmt::format(
          ".RI {} {} {}\n", o.required ? "\"\"" : "[", roff(o.names.front()),
          std::string(o.required ? "" : "]") + (o.many ? "..." : "") + (o.required && !o.many ? "\"\"" : ""));
  return text + "[\\fIOPTIONS\\fR]\n";
}

std::string options_text(const CommandTree& c) {
  std::string text;
  for (const DescribedOption& o : c.options) {
    std::string names;
    for (const std::string& name : o.names)
      names += (names.empty() ? "" : ", ") + ("\\fB" + roff(name) + "\\fR");
    if (!o.positional && !o.value.empty()) {
      std::string choices;
      for (const std::string& choice : o.choices) choices += (choices.empty() ? "" : "|") + choice;
      names += " \\fI" + roff(choices.empty() ? o.value : choices) + "\\fR";
    }
    text += ".TP\n" + names + "\n" + roff(o.help.empty() ? "no help" : o.help) + "\n";
  }
  return text;
}

std::string head(const std::string& name, const std::string& version, const std::string& summary) {
  std::string upper = name;
  std::ranges::transform(upper, upper.begin(), [](unsigned char c) { return std::toupper(c); });
  return fmt::format(".TH {} 1 \"\" \"firn {}\" \"Firn\"\n.SH NAME\n{} \\- {}\n", roff(upper), roff(version),
                     roff(name), roff(summary));
}

constexpr const char* kExitStatus =
    ".SH EXIT STATUS\n.TP\n0\nsuccess\n.TP\n1\nfailed, or the comparison differs\n.TP\n2\nusage or "
    "configuration\n.TP\n3\n"
    "an instrument's fault or a safety stop\n.TP\n4\nthe print ran to its end, but the part is out of "
    "tolerance\n.TP\n130\n"
    "interrupted; the lab was made safe first\n";

}  // namespace

std::vector<ManPage> man_pages(const CommandTree& program, const std::string& version) {
  std::vector<ManPage> pages;
  std::string commands;
  for (const CommandTree& c : program.subcommands)
    commands += fmt::format(".TP\n\\fBfirn {}\\fR\n{}\n", roff(c.name), roff(c.summary));
  pages.push_back(
      {program.name, head(program.name, version, program.summary) + ".SH SYNOPSIS\n" +
                         synopsis(program.name, program) + ".SH COMMANDS\n" + commands + ".SH OPTIONS\n" +
                         options_text(program) + kExitStatus +
                         ".SH EXAMPLES\n.nf\nfirn print experiments/cylinder.toml\nfirn report runs/*\n"
                         "firn compare experiments/studies/schemes.toml --seeds 10\n.fi\n"});
  for (const CommandTree& c : program.subcommands) {
    const std::string name = program.name + "-" + c.name, words = program.name + " " + c.name;
    std::string text = head(name, version, c.summary) + ".SH SYNOPSIS\n" + synopsis(words, c);
    if (!c.options.empty()) text += ".SH OPTIONS\n" + options_text(c);
    for (const CommandTree& s : c.subcommands)
      text += fmt::format(".SH {}\n{}.PP\n", roff(words + " " + s.name), roff(s.summary) + "\n") +
              synopsis(words + " " + s.name, s) + options_text(s);
    text += kExitStatus +
            fmt::format(".SH SEE ALSO\n.BR firn (1);\n.B firn help {}\nshows more.\n", roff(c.name));
    pages.push_back({name, text});
  }
  return pages;
}

}  // namespace firn
