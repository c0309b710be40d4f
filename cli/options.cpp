#include "cli/options.h"

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <optional>

#include "cli/commands.h"
#include "cli/option_set.h"
#include "files/nearest.h"
#include "files/usage_error.h"
#include "print/exit_codes.h"
#include "runtime/build_info.h"

namespace firn {

Argument& Argument::required() {
  option_.required();
  return *this;
}
Argument& Argument::show_default() {
  option_.capture_default_str();
  return *this;
}
Argument& Argument::one_value_each() {
  option_.allow_extra_args(false);
  return *this;
}
Argument& Argument::separated_by(char separator) {
  option_.delimiter(separator);
  return *this;
}
Argument& Argument::number_of_values(int count) {
  option_.expected(count);
  return *this;
}
Argument& Argument::within(int minimum, int maximum) {
  option_.check(CLI::Range(minimum, maximum));
  return *this;
}
Argument& Argument::within(double minimum, double maximum) {
  const auto no_number = [](const std::string& text) {  // the parser library's range lets it pass
    double number = 0.0;
    return CLI::detail::lexical_cast(text, number) && std::isnan(number) ? text + " is not a number"
                                                                         : std::string();
  };
  option_.check(CLI::Validator(no_number, ""));
  option_.check(CLI::Range(minimum, maximum));
  return *this;
}
// The parser library has a check of its own; its message writes the largest double out.
Argument& Argument::above_zero() {
  const auto problem = [](const std::string& text) {
    double number = 0.0;
    const bool read = CLI::detail::lexical_cast(text, number);
    return read && number > 0.0 && std::isfinite(number) ? std::string() : text + " is not a number above 0";
  };
  option_.check(CLI::Validator(problem, "above 0"));
  return *this;
}
Argument& Argument::one_of(std::vector<std::string> words) {
  option_.check(CLI::IsMember(std::move(words)));
  return *this;
}

template <class T>
Argument OptionSet::option(const std::string& name, T& value, const std::string& help) {
  return Argument(*app_.add_option(name, value, help));
}
#define FIRN_OPTION(T) template Argument OptionSet::option(const std::string&, T&, const std::string&)
FIRN_OPTION(std::string);
FIRN_OPTION(int);
FIRN_OPTION(std::int64_t);
FIRN_OPTION(std::uint64_t);
FIRN_OPTION(double);
FIRN_OPTION(std::optional<int>);
FIRN_OPTION(std::optional<double>);
FIRN_OPTION(std::vector<std::string>);
FIRN_OPTION(std::vector<int>);
FIRN_OPTION(std::vector<double>);
#undef FIRN_OPTION

void OptionSet::flag(const std::string& name, bool& value, const std::string& help) {
  app_.add_flag(name, value, help);
}

void OptionSet::override_option(std::vector<std::string>& overrides, const std::string& help) {
  option("--set", overrides, help).one_value_each();
}

void OptionSet::thread_option(int& threads, const std::string& more) {
  option("--threads", threads, "0 = as many as the machine has" + more).show_default().within(0, 1024);
}

OptionSet OptionSet::subcommand(const std::string& name, const std::string& summary) {
  return {*app_.add_subcommand(name, summary), run_};
}

void OptionSet::require_subcommand() { app_.require_subcommand(1); }

void OptionSet::when_parsed(Run call) {
  // The parser calls a command's subcommands first, then the command itself.
  app_.final_callback([&app = app_, &run = run_, call = std::move(call)] {
    if (app.get_subcommands().empty()) run = call;
  });
}

namespace {

Call printed(const std::string& text) {
  return {"", [text] {
            std::fputs(text.c_str(), stdout);
            return int(kOk);
          }};
}

Call refused(const CLI::App& app, const std::string& command, std::string problem) {
  for (char& c : problem)
    if (c == '\n') c = ' ';
  const std::string help =
      "\n(" + app.get_name() + (command.empty() ? "" : " " + command) + " --help lists what there is)";
  return {command, [problem, help]() -> int { throw UsageError(problem + help); }};
}

/// "config check"
std::string chosen(const CLI::App& app) {
  std::string command;
  for (const CLI::App* a = &app; !a->get_subcommands().empty();) {
    a = a->get_subcommands().front();
    command += (command.empty() ? "" : " ") + a->get_name();
  }
  return command;
}

}  // namespace

Call parse_command_line(std::span<const Command> commands, int argc, const char* const* argv) {
  CLI::App app("Closed-loop additive manufacturing: print, measure, decide, record, replay.", "firn");
  app.set_version_flag("--version", std::string("firn ") + build_commit());
  app.require_subcommand(1);
  OptionSet::Run run;
  OptionSet all(app, run);
  std::vector<std::string_view> names;
  for (const Command& c : commands) {
    OptionSet options = all.subcommand(c.name, c.summary);
    c.declare(options);
    names.push_back(c.name);
  }
  if (const std::string word = argc > 1 ? argv[1] : "";
      !word.empty() && word[0] != '-' && std::find(names.begin(), names.end(), word) == names.end()) {
    if (names.size() == 1)  // a program that is small so that it is built soon
      return refused(app, "",
                     "unknown command '" + word + "': this program has " + std::string(names[0]) +
                         " alone; try ./firn " + word);
    const std::string near = nearest(word, names);
    return refused(
        app, "",
        "unknown command '" + word + "'" + (near.empty() ? "" : "; the nearest known one is " + near));
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp&) {
    return printed(app.help());
  } catch (const CLI::CallForVersion&) {
    return printed(app.version() + "\n");
  } catch (const CLI::ParseError& e) {
    return refused(app, chosen(app), e.what());
  }
  return {chosen(app), run};
}

}  // namespace firn
