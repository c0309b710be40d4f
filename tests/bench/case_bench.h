// CaseBench makes a bench of many independent cases a study: shards, other computers, resuming and state are
// those of firn compare.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cli/option_set.h"
#include "cli/study_options.h"
#include "studies/compare/study_work.h"

namespace firn::bench {

/// Every kind is made under every seed.
struct Cases {
  std::string name;      ///< of the bench
  std::string settings;  ///< all that decides a case beside its kind and seed
  std::vector<std::string> kinds;
  std::vector<std::uint64_t> seeds;
  /// Returns a case's result as text. An exception is a failed case, with its words as the cause.
  /// @param threads that it may use
  std::function<std::string(std::size_t kind, std::uint64_t seed, int threads)> make;
  bool one_by_one = false;  ///< a case uses several threads itself
};

/// Numbers as the text of a case, the same to the last bit; an infinite one comes back as NaN.
std::string text_of(const std::vector<double>& numbers);
std::vector<double> numbers_of(const std::string& text);

class CaseBench {
 public:
  /// @param name as the bench is called @param about one line
  CaseBench(const std::string& name, const std::string& about);
  ~CaseBench();

  /// For the bench's own options; those of studies and -o are declared already.
  OptionSet& options() { return options_; }
  StudyOptions study;

  /// @returns the exit code where the command line asks for no cases or has a mistake, which is told
  std::optional<int> parse(int argc, char** argv);

  /// One result each, kind by kind in the order of the seeds; `code` says why there are none.
  struct Result {
    bool made = false;
    std::string text, reason;
    double cpu_s = 0.0;
  };
  /// @param words of the bench's own options for a shard on another computer; paths are absolute
  std::optional<std::vector<Result>> results(const Cases& cases, const std::vector<std::string>& words,
                                             int& code) const;

 private:
  std::string name_, program_;
  std::unique_ptr<CLI::App> app_;
  OptionSet::Run run_;
  OptionSet options_;
};

}  // namespace firn::bench
