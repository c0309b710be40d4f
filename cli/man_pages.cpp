#include <fmt/core.h>

#include <algorithm>

#include "cli/command_tree.h"
#include "files/exit_codes.h"

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

std::string exit_status() {
  std::string text = ".SH EXIT STATUS\n";
  for (const ExitMeaning& e : kExitMeanings)
    text += fmt::format(".TP\n{}\n{}\n", int(e.code), roff(e.meaning));
  return text;
}

// As they stand in the help text.
std::string examples(const CommandTree& c) {
  if (c.examples.empty()) return "";
  const std::size_t head = c.examples.find('\n') + 1;
  std::string text = ".SH EXAMPLES\n.nf\n";
  for (std::size_t at = head, end; at < c.examples.size(); at = end + 1) {
    end = std::min(c.examples.find('\n', at), c.examples.size());
    text += roff(c.examples.substr(at, end - at)) + "\n";
  }
  return text + ".fi\n";
}

}  // namespace

std::vector<ManPage> man_pages(const CommandTree& program, const std::string& version) {
  std::vector<ManPage> pages;
  std::string commands, group;
  for (const CommandTree& c : program.subcommands) {
    if (c.group != group) commands += ".SS " + roff(group = c.group) + "\n";
    commands += fmt::format(".TP\n\\fBfirn {}\\fR\n{}\n", roff(c.name), roff(c.summary));
  }
  pages.push_back(
      {program.name, head(program.name, version, program.summary) + ".SH SYNOPSIS\n" +
                         synopsis(program.name, program) + ".SH COMMANDS\n" + commands + ".SH OPTIONS\n" +
                         options_text(program) + exit_status() +
                         ".SH FILES\n.TP\n~/.config/firn/config.toml\nyour own configuration; "
                         "\\fBfirn help config\\fR\n"
                         ".SH ENVIRONMENT\n.TP\nFIRN_RUNS\nfolder of run folders, where none is given\n"});
  for (const CommandTree& c : program.subcommands) {
    const std::string name = program.name + "-" + c.name, words = program.name + " " + c.name;
    std::string text = head(name, version, c.summary) + ".SH SYNOPSIS\n" + synopsis(words, c);
    if (!c.options.empty()) text += ".SH OPTIONS\n" + options_text(c);
    for (const CommandTree& s : c.subcommands)
      text += fmt::format(".SH {}\n{}.PP\n", roff(words + " " + s.name), roff(s.summary) + "\n") +
              synopsis(words + " " + s.name, s) + options_text(s);
    text += exit_status() + examples(c) +
            fmt::format(".SH SEE ALSO\n.BR firn (1);\n.B firn help {}\nshows more.\n", roff(c.name));
    pages.push_back({name, text});
  }
  return pages;
}

}  // namespace firn
