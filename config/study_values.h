// StudyValues reads the values that studies and declarations of worlds have in common: names, texts, lists.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace toml {
inline namespace v3 {
class node;
}  // namespace v3
}  // namespace toml

namespace firn {

class StudyValues {
 public:
  explicit StudyValues(std::string file) : file_(std::move(file)) {}
  const std::string& file() const { return file_; }

  /// Each throws ConfigError naming file, line, key and limit.
  [[noreturn]] void fail(int line, const std::string& key, const std::string& problem) const;
  [[noreturn]] void unknown(const std::string& key, int line,
                            const std::vector<std::string_view>& known) const;
  std::string text_of(const toml::node& node, const std::string& key, int line) const;
  std::string name_of(const toml::node& node, const std::string& key, int line) const;
  std::vector<std::string> overrides_of(const toml::node& node, const std::string& key, int line) const;
  std::vector<std::string> metrics_of(const toml::node& node, int line) const;

 private:
  std::string file_;
};

}  // namespace firn
