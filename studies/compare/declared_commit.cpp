#include "studies/compare/declared_commit.h"

#include <span>
#include <stdexcept>

#include "config/include.h"
#include "files/command.h"
#include "files/digest.h"

namespace firn {
namespace {

std::string line_of(std::string text) {
  while (!text.empty() && text.back() == '\n') text.pop_back();
  return text;
}

std::string commit_words(const std::filesystem::path& file) try {
  const std::filesystem::path folder = file.has_parent_path() ? file.parent_path() : ".";
  const std::string name = file.filename().string();
  const auto git = [&](std::vector<std::string> words) {
    words.insert(words.begin(), {"git", "-C", folder.string()});
    words.insert(words.end(), {"--", name});
    return run_command(words);
  };
  const CommandEnd log = git({"log", "-1", "--format=%H"}), changed = git({"status", "--porcelain"});
  if (log.missing()) return "unknown: git is not installed";
  if (changed.code != 0) return "unknown: " + changed.reason();
  if (log.code != 0 || line_of(log.output).empty())  // git log fails where there is no commit at all
    return "none: the file is in no commit";
  return line_of(log.output) + (changed.output.empty() ? "" : ", and changed since");
} catch (const std::runtime_error& error) {
  return std::string("unknown: ") + error.what();
}

}  // namespace

std::string declared_commit(const std::filesystem::path& file) {
  const std::string text = read_config_text(file);
  return commit_words(file) + "; SHA-256 " + sha256_hex(std::as_bytes(std::span(text)));
}

}  // namespace firn
