// OptionSet declares the arguments of one command and binds them to the members of its options struct. It
// hides the parser library, whose headers are expensive to read.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "cli/command_tree.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace firn {

struct Product;

/// A declared argument. Each call adds one property to it.
class Argument {
 public:
  explicit Argument(CLI::Option& option) : option_(option) {}

  Argument& required();
  Argument& show_default();                ///< in the help text
  Argument& one_value_each();              ///< a further value is given by the option's name again
  Argument& separated_by(char separator);  ///< "1,2,3" gives three values
  Argument& number_of_values(int count);
  Argument& within(int minimum, int maximum);
  Argument& within(double minimum, double maximum);
  Argument& above_zero();
  Argument& not_empty();
  Argument& one_of(std::vector<std::string> words);

 private:
  CLI::Option& option_;
};

class OptionSet {
 public:
  using Run = std::function<int()>;

  /// @param product of the program, for commands that print or read prints; outlives their calls
  /// @param run receives the call of the command that the command line names; must outlive the set
  OptionSet(CLI::App& app, const Product& product, Run& run) : app_(app), product_(product), run_(run) {}

  /// Names the function that carries out the command.
  /// @returns its options with their defaults. They live as long as the call that holds them.
  template <class Options>
  Options& calls(int (*command)(const Options&)) {
    auto options = std::make_shared<Options>();
    when_parsed([options, command] { return command(*options); });
    return *options;
  }
  template <class Options>
  Options& calls(int (*command)(const Product&, const Options&)) {
    auto options = std::make_shared<Options>();
    when_parsed([options, command, &product = product_] { return command(product, *options); });
    return *options;
  }

  /// The same for a command that describes the program itself.
  template <class Options>
  Options& calls(int (*command)(const CommandTree&, const Options&)) {
    auto options = std::make_shared<Options>();
    when_parsed_by([options, command, this_program = program_describer()]() -> Run {
      return [options, command, tree = this_program()] { return command(tree, *options); };
    });
    return *options;
  }

  /// @param name "RUN", "--seed" or "-o,--output"
  /// @param value std::string, int, std::int64_t, std::uint64_t, double, std::optional or std::vector of them
  template <class T>
  Argument option(const std::string& name, T& value, const std::string& help);
  void flag(const std::string& name, bool& value, const std::string& help);
  /// Declares `--json`.
  void json_flag(bool& json) { flag("--json", json, "machine-readable output"); }
  /// Declares `--set KEY=VALUE`.
  void override_option(std::vector<std::string>& overrides,
                       const std::string& help = "KEY=VALUE, after the file");
  /// Declares `--runs`, the folder of run folders; it is default_runs_folder() where the command line names
  /// none.
  void runs_option(std::string& runs, const std::string& help);
  void runs_option(std::vector<std::string>& runs, const std::string& help);  ///< given several times
  /// Declares `--threads`.
  /// @param more appended to the help text
  void thread_option(int& threads, const std::string& more = "");

  OptionSet subcommand(const std::string& name, const std::string& summary);
  void require_subcommand();

 private:
  void when_parsed(Run call);
  void when_parsed_by(std::function<Run()> call);  // of which the call is made while the parser lives
  std::function<CommandTree()> program_describer() const;

  using Wishes = std::vector<std::function<void()>>;

  CLI::App& app_;
  const Product& product_;
  Run& run_;
  std::shared_ptr<Wishes> wishes_ = std::make_shared<Wishes>();  ///< of the user: before the call is made
};

}  // namespace firn
