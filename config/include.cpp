#include "config/include.h"

#include <algorithm>
#include <fstream>
#include <iterator>

#include "config/error.h"
#include "config/machine.h"

namespace firn {
namespace {

constexpr std::size_t kMaxLevels = 8;

}  // namespace

std::string read_config_text(const std::filesystem::path& path, const std::string& included_by) {
  const std::string from = included_by.empty() ? "" : " (included by " + included_by + ")";
  std::error_code error;
  if (std::filesystem::is_directory(path, error))
    throw ConfigError(path.string(), 0, "", "is a folder, not a file" + from);
  if (!std::filesystem::is_regular_file(path, error))
    throw ConfigError(path.string(), 0, "", "no such file" + from);
  std::ifstream in(path, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(in), {}};
  if (!in) throw ConfigError(path.string(), 0, "", "cannot be read" + from);
  return text;
}

std::vector<std::pair<std::string, std::string>> read_with_includes(const std::filesystem::path& path) {
  std::vector<std::pair<std::string, std::string>> texts;
  std::vector<std::filesystem::path> seen;
  std::filesystem::path next = path;
  std::string included_by;
  while (!next.empty()) {
    const std::filesystem::path canonical = std::filesystem::weakly_canonical(next);
    if (std::find(seen.begin(), seen.end(), canonical) != seen.end() || seen.size() == kMaxLevels)
      throw ConfigError(included_by, 0, "include",
                        "include = \"" + next.string() + "\": comes back to itself or goes deeper than " +
                            std::to_string(kMaxLevels) + " files");
    seen.push_back(canonical);
    texts.emplace_back(next.string(), read_config_text(next, included_by));
    const std::string include = include_of(texts.back().second, texts.back().first);
    included_by = next.string();
    next = include.empty() ? std::filesystem::path() : (next.parent_path() / include).lexically_normal();
  }
  std::reverse(texts.begin(), texts.end());
  return texts;
}

Experiment load_experiment(const std::filesystem::path& path, const std::vector<std::string>& overrides,
                           LabUse use) {
  return parse_experiment(read_with_includes(path), overrides, use);
}

PrintMeta load_meta(const std::filesystem::path& path, const std::vector<std::string>& overrides) {
  return parse_meta(read_with_includes(path), overrides);
}

// Here, because nodes parse machines and open no file.
Machine load_machine(const std::filesystem::path& path) {
  return parse_machine(read_config_text(path), path.string());
}

}  // namespace firn
