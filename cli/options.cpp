#include "cli/options.h"

#include <fmt/core.h>
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <optional>
#include <type_traits>

#include "cli/option_set.h"
#include "cli/short_help.h"
#include "cli/user_config.h"
#include "files/exit_codes.h"
#include "files/nearest.h"
#include "files/usage_error.h"
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
  const auto problem = [minimum, maximum](const std::string& text) {
    double number = 0.0;
    const bool read = CLI::detail::lexical_cast(text, number);
    return read && number >= minimum && number <= maximum
               ? std::string()
               : fmt::format("Value {} not in range {:g} to {:g}", text, minimum, maximum);
  };
  option_.check(CLI::Validator(problem, fmt::format("FLOAT in [{:g} - {:g}]", minimum, maximum)));
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
Argument& Argument::not_empty() {
  const auto problem = [](const std::string& text) {
    return text.empty() ? std::string("the value is empty") : std::string();
  };
  option_.check(CLI::Validator(problem, ""));
  return *this;
}
Argument& Argument::one_of(std::vector<std::string> words) {
  option_.check(CLI::IsMember(std::move(words)));
  return *this;
}

namespace {

template <class T>
struct NumberOf {
  using type = T;
};
template <class T>
struct NumberOf<std::optional<T>> {
  using type = T;
};
template <class T>
struct NumberOf<std::vector<T>> {
  using type = T;
};

// The parser library reads "" as 0, the infinite as a number, -1 as the largest unsigned number and a whole
// number that is too large as the largest one.
template <class Number>
std::string number_problem(const std::string& text) {
  if (text.empty()) return "the value is empty";
  if constexpr (std::is_floating_point_v<Number>) {
    Number number = 0;
    return CLI::detail::lexical_cast(text, number) && !std::isfinite(number)
               ? text + " is not a finite number"
               : std::string();
  } else {
    using Limits = std::numeric_limits<Number>;
    errno = 0;
    bool outside = false;
    if constexpr (std::is_signed_v<Number>) {
      const long long number = std::strtoll(text.c_str(), nullptr, 0);
      outside = number < Limits::min() || number > Limits::max();
    } else {
      std::strtoull(text.c_str(), nullptr, 0);
      outside = text.find('-') != std::string::npos;
    }
    return outside || errno == ERANGE
               ? fmt::format("{} is not a whole number from {} to {}", text, Limits::min(), Limits::max())
               : std::string();
  }
}

}  // namespace

template <class T>
Argument OptionSet::option(const std::string& name, T& value, const std::string& help) {
  using Number = typename NumberOf<T>::type;
  CLI::Option& added = *app_.add_option(name, value, help);
  if constexpr (std::is_arithmetic_v<Number>) added.check(CLI::Validator(number_problem<Number>, ""));
  return Argument(added);
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

void OptionSet::runs_option(std::string& runs, const std::string& help) {
  CLI::Option& added =
      *app_.add_option("--runs", runs, help + "; default: FIRN_RUNS, your configuration, runs");
  wishes_->push_back([&added, &runs] {
    if (added.count() == 0) runs = default_runs_folder().folder;
  });
}

void OptionSet::runs_option(std::vector<std::string>& runs, const std::string& help) {
  CLI::Option& added =
      *app_.add_option("--runs", runs, help + "; default: FIRN_RUNS, your configuration, runs");
  added.type_size(1);
  added.allow_extra_args(false);
  wishes_->push_back([&added, &runs] {
    if (added.count() == 0) runs = {default_runs_folder().folder};
  });
}

void OptionSet::thread_option(int& threads, const std::string& more) {
  option("--threads", threads, "0 = as many as the machine has" + more).show_default().within(0, 1024);
}

OptionSet OptionSet::subcommand(const std::string& name, const std::string& summary) {
  return {*app_.add_subcommand(name, summary), product_, run_};
}

void OptionSet::require_subcommand() { app_.require_subcommand(1); }

void OptionSet::when_parsed(Run call) {
  when_parsed_by([call = std::move(call)] { return call; });
}

void OptionSet::when_parsed_by(std::function<Run()> call) {
  // The parser calls a command's subcommands first, then the command itself.
  app_.final_callback([&app = app_, &run = run_, wishes = wishes_, call = std::move(call)] {
    if (!app.get_subcommands().empty()) return;
    for (const std::function<void()>& wish : *wishes) wish();
    run = call();
  });
}

namespace {

// "{a,b}" in the type of an option that takes one of some words.
std::vector<std::string> choices_in(const std::string& type) {
  std::vector<std::string> choices;
  const std::size_t open = type.find('{'), close = type.find('}');
  if (open == std::string::npos || close == std::string::npos) return choices;
  for (std::size_t at = open + 1; at < close;) {
    const std::size_t end = std::min(type.find(',', at), close);
    choices.push_back(type.substr(at, end - at));
    at = end + 1;
  }
  return choices;
}

CommandTree described(const CLI::App& app) {
  CommandTree tree{app.get_name(), app.get_description(), app.get_group(), app.get_footer(), {}, {}};
  for (const CLI::Option* option : app.get_options()) {
    DescribedOption o;
    o.positional = option->nonpositional() == false;
    o.required = option->get_required();
    o.many = option->get_expected_max() > 1;
    o.help = option->get_description();
    if (o.positional) {
      o.names = {option->get_name(true)};
    } else {
      for (const std::string& name : option->get_snames()) o.names.push_back("-" + name);
      for (const std::string& name : option->get_lnames()) o.names.push_back("--" + name);
    }
    if (option->get_items_expected_max() > 0) o.value = "VALUE";
    o.choices = choices_in(option->get_type_name());
    tree.options.push_back(std::move(o));
  }
  for (const CLI::App* sub : app.get_subcommands([](const CLI::App*) { return true; }))
    tree.subcommands.push_back(described(*sub));
  return tree;
}

}  // namespace

std::function<CommandTree()> OptionSet::program_describer() const {
  return [app = &app_] {
    const CLI::App* root = app;
    while (root->get_parent()) root = root->get_parent();
    return described(*root);
  };
}

namespace {

Call printed(const std::string& text) {
  return {"",
          [text] {
            std::fputs(text.c_str(), stdout);
            return int(kOk);
          },
          ""};
}

Call refused(const CLI::App& app, const std::string& command, std::string problem) {
  for (char& c : problem)
    if (c == '\n') c = ' ';
  const std::string help =
      "\n(" + app.get_name() + (command.empty() ? "" : " " + command) + " --help lists what there is)";
  return {command, [problem, help]() -> int { throw UsageError(problem + help); }, problem};
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

// The end of a command's help text.
std::string examples_text(const Command& command) {
  std::string text;
  for (const Example& e : command.examples)
    if (*e.line) text += fmt::format("  {}\n      {}\n", e.line, e.purpose);
  return text.empty() ? text : "Examples:\n" + text;
}

bool has_empty_item(const std::string& list, char separator) {
  return list.empty() || list.front() == separator || list.back() == separator ||
         list.find(std::string(2, separator)) != std::string::npos;
}

// The parser library drops empty items of a list.
std::string empty_item(const CLI::App& app, int argc, const char* const* argv) {
  const CLI::App* command = &app;
  while (!command->get_subcommands().empty()) command = command->get_subcommands().front();
  for (int n = 1; n < argc; ++n) {
    const std::string word = argv[n];
    if (word.rfind("--", 0) != 0) continue;
    const std::size_t equals = word.find('=');
    const CLI::Option* option = command->get_option_no_throw(word.substr(0, equals));
    if (option == nullptr || option->get_delimiter() == '\0') continue;
    if (equals == std::string::npos && n + 1 == argc) continue;
    const std::string list = equals == std::string::npos ? argv[n + 1] : word.substr(equals + 1);
    if (has_empty_item(list, option->get_delimiter()))
      return fmt::format("{}: \"{}\" has an empty item; items are separated by one '{}'",
                         word.substr(0, equals), list, option->get_delimiter());
  }
  return "";
}

}  // namespace

Call parse_command_line(std::span<const Command> commands, const Product& product, int argc,
                        const char* const* argv) {
  CLI::App app("Closed-loop additive manufacturing: print, measure, decide, record, replay.", "firn");
  app.set_version_flag("--version", build_name());
  app.require_subcommand(1);
  OptionSet::Run run;
  OptionSet all(app, product, run);
  std::vector<std::string_view> names;
  for (const Command& c : commands) {
    OptionSet options = all.subcommand(c.name, c.summary);
    c.declare(options);
    CLI::App& added = *app.get_subcommand(c.name);
    added.group(c.group);
    added.footer(examples_text(c));
    names.push_back(c.name);
  }
  if (argc == 1) return printed(commands.size() == 1 ? app.help() : kShortHelp);
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
    const std::string problem =
        empty_item(app, argc, argv);  // of which the library says "1 required missing"
    return refused(app, chosen(app), problem.empty() ? e.what() : problem);
  } catch (const std::exception&) {  // of the user's configuration
    return {chosen(app), [error = std::current_exception()]() -> int { std::rethrow_exception(error); }, ""};
  }
  if (const std::string problem = empty_item(app, argc, argv); !problem.empty())
    return refused(app, chosen(app), problem);
  return {chosen(app), run, ""};
}

}  // namespace firn
