#include "cli/output_files.h"

#include <unistd.h>

#include <algorithm>
#include <system_error>

#include "files/lowercase.h"
#include "files/usage_error.h"

namespace firn {

void check_output_files(std::vector<std::filesystem::path> inputs,
                        std::initializer_list<std::string> outputs) {
  std::vector<std::filesystem::path>& taken = inputs;
  for (const std::string& file : outputs) {
    if (file.empty()) continue;
    for (const std::filesystem::path& other : taken) {
      std::error_code error;
      if (other.lexically_normal() == std::filesystem::path(file).lexically_normal() ||
          std::filesystem::equivalent(file, other, error))
        throw UsageError(file + ": would take the place of " + other.string());
    }
    taken.push_back(file);
  }
}

void check_writable(std::initializer_list<std::string> outputs) {
  for (const std::string& file : outputs) {
    if (file.empty()) continue;
    std::error_code error;
    if (std::filesystem::is_directory(file, error)) throw UsageError(file + ": is a folder, not a file");
    std::filesystem::path folder = std::filesystem::path(file).parent_path();
    if (folder.empty()) folder = ".";
    if (!std::filesystem::is_directory(folder, error))
      throw UsageError(file + ": there is no folder " + folder.string());
    if (::access(folder.c_str(), W_OK) != 0)
      throw UsageError(file + ": the folder " + folder.string() + " cannot be written to");
  }
}

void check_ending(std::string_view option, const std::string& file,
                  std::span<const std::string_view> endings) {
  if (file.empty()) return;
  const std::string has = lowercase(std::filesystem::path(file).extension().string());
  if (std::ranges::find(endings, has) != endings.end()) return;
  std::string known;
  for (std::size_t n = 0; n < endings.size(); ++n)
    known += (n == 0 ? "" : n + 1 == endings.size() ? " or " : ", ") + std::string(endings[n]);
  throw UsageError(std::string(option) + " " + file + ": must end in " + known);
}

}  // namespace firn
