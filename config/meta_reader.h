// MetaReader gathers [meta], its declarations in [lab.meta], and the limits of [lab.use] while a
// configuration is read.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "config/meta.h"

namespace firn {

/// A value of a configuration file, or a table or a list of them.
struct MetaNode {
  std::optional<MetaValue> value;  ///< nothing: a table, a list, or a kind that [meta] cannot have
  bool is_table = false, is_list = false;
  std::string key;  ///< of a member of a table
  int line = 0;
  std::vector<MetaNode> members;
};

class MetaReader {
 public:
  /// Returns true for the three sections that it reads.
  static bool reads(std::string_view key) { return key == "meta" || key == "lab.meta" || key == "lab.use"; }
  /// @throws ConfigError naming key, value and requirement
  void read(std::string_view section, const MetaNode& node, const std::string& file, int line);
  /// Takes "meta.KEY=VALUE" of a command line. The type that a lab declares is that of VALUE; without
  /// one a number is a number, and all else is text.
  /// @param written as TOML reads it @param word the value as a text
  void override_with(const std::string& key, const MetaNode& written, const std::string& word);
  /// Returns the checked values.
  PrintMeta finish() const;
  /// Returns a run's name with a value in the place of each {meta.KEY}.
  /// @throws ConfigError at `file` and `line`: a key that is not set, a value that no file name can have
  std::string expand(const std::string& name, const std::string& file, int line) const;

 private:
  enum class Type : std::uint8_t { kText, kNumber, kInteger, kBoolean, kDate };
  struct Rule {
    Type type = Type::kText;
    bool required = false;
    std::vector<std::string> words;  // one of these; empty: any
    std::string meaning, file;
    int line = 0;
  };
  struct Given {
    MetaValue value;
    std::optional<std::string> word;  // of a command line
    std::string file;
    int line = 0;
  };

  void declare(const std::string& key, const MetaNode& node, const std::string& file, int line);
  void limit(const MetaNode& member, const std::string& file);
  MetaValue checked(const std::string& key, const Given& given) const;

  std::map<std::string, Rule> rules_;
  std::map<std::string, Given> given_;
  std::map<std::string, double> limits_;
  double warn_percent_ = UseLimits{}.warn_percent;
};

}  // namespace firn
