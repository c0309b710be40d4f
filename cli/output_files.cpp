#include "cli/output_files.h"

#include <system_error>

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

}  // namespace firn
