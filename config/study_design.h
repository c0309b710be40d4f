// DesignReader reads the sections of a study file that vary keys: [vary], [zip] and [sample] make settings of
// its schemes, [prior] draws a lab for each seed.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "config/study.h"
#include "config/study_ranges.h"

namespace toml {
inline namespace v3 {
class node;
class table;
}  // namespace v3
}  // namespace toml

namespace firn {

class DesignReader {
 public:
  explicit DesignReader(const std::string& file) : file_(file) {}

  static constexpr std::string_view kSections[] = {"vary", "zip", "sample", "prior"};
  static bool knows(std::string_view section);
  /// @throws ConfigError naming file, line, key and limit
  void read(const std::string& section, const toml::node& node, int line);

  /// Returns every scheme under every combination of the settings; of several sections and keys the last
  /// changes fastest. @throws ConfigError: there are more than kMaxArms; a key is varied twice
  std::vector<StudyEntry> combined(std::vector<StudyEntry> schemes) const;
  const std::vector<KeyRange>& priors() const { return priors_; }
  bool varies() const { return !factors_.empty(); }

 private:
  /// One setting out of several: a value for each of some keys.
  struct Level {
    std::string name;
    std::vector<std::string> overrides;
    void add(const std::string& key, const std::string& value);
  };
  struct Factor {
    std::vector<std::string> keys;
    std::vector<Level> levels;
    int line = 0;
  };

  void vary(const toml::table& table);
  void zip(const toml::table& table, int line);
  void sample(const toml::table& table, int line);
  void prior(const toml::table& table);
  KeyRange range_of(const std::string& section, const std::string& key, const toml::node& node,
                    int line) const;
  [[noreturn]] void fail(int line, const std::string& key, const std::string& problem) const;

  std::string file_;
  std::vector<Factor> factors_;
  std::vector<KeyRange> priors_;
};

}  // namespace firn
