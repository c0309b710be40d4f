#include "config/study_values.h"

#include <algorithm>

#define TOML_SHARED_LIB 1
#include <toml++/toml.h>

#include "config/error.h"
#include "files/nearest.h"

namespace firn {
namespace {

constexpr std::size_t kMaxName = 60, kMaxOverrides = 200, kMaxMetrics = 20;

}  // namespace

void StudyValues::fail(int line, const std::string& key, const std::string& problem) const {
  throw ConfigError(file_, line, key, key + ": " + problem);
}

void StudyValues::unknown(const std::string& key, int line,
                          const std::vector<std::string_view>& known) const {
  const std::string near = nearest(key, known);
  fail(line, key.substr(0, 100), "unknown key" + (near.empty() ? "" : "; the nearest known one is " + near));
}

std::string StudyValues::text_of(const toml::node& node, const std::string& key, int line) const {
  if (!node.is_string()) fail(line, key, "must be text");
  const std::string text = node.as_string()->get();
  if (text.empty() || text.size() > 1000) fail(line, key, "must have 1 to 1000 bytes");
  for (unsigned char c : text)
    if (c < 0x20 || c == 0x7f) fail(line, key, "must not contain control characters");
  return text;
}

std::string StudyValues::name_of(const toml::node& node, const std::string& key, int line) const {
  const std::string name = text_of(node, key, line);
  const bool plain = std::all_of(name.begin(), name.end(), [](unsigned char c) {
    return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '.' ||
           c == '_' || c == '-' || c == ' ' || c == '+';
  });
  if (!plain || name.size() > kMaxName || name.front() == '.' || name.front() == ' ')
    fail(line, key,
         "must be 1 to 60 letters, digits, '.', '_', '-', '+' or blanks, and not begin with '.' or a blank");
  return name;
}

std::vector<std::string> StudyValues::overrides_of(const toml::node& node, const std::string& key,
                                                   int line) const {
  const toml::array* list = node.as_array();
  if (!list || list->size() > kMaxOverrides)
    fail(line, key, "must be a list of at most 200 texts \"KEY=VALUE\"");
  std::vector<std::string> out;
  for (const toml::node& entry : *list) out.push_back(text_of(entry, key, line));
  return out;
}

std::vector<std::string> StudyValues::metrics_of(const toml::node& node, int line) const {
  const toml::array* list = node.as_array();
  if (!list || list->empty() || list->size() > kMaxMetrics)
    fail(line, "metrics", "must be a list of 1 to 20 names, the primary one first");
  std::vector<std::string> metrics;
  for (const toml::node& entry : *list) {
    const std::string name = name_of(entry, "metrics", line);
    if (std::ranges::find(metrics, name) != metrics.end()) fail(line, "metrics", "names " + name + " twice");
    metrics.push_back(name);
  }
  return metrics;
}

}  // namespace firn
