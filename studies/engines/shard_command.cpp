#include "studies/engines/shard_command.h"

#include <system_error>

#include "files/command.h"
#include "files/text_file.h"
#include "files/usage_error.h"

namespace firn {

std::string ShardCommand::line(const std::string& number) const {
  std::string all;
  for (const std::string& w : words) all += shell_word(w) + " ";
  return all + "--shard " + number + "/" + std::to_string(shards);
}

std::string ranges_text(const std::vector<int>& numbers) {
  std::string text;
  for (std::size_t n = 0; n < numbers.size();) {
    std::size_t last = n;
    while (last + 1 < numbers.size() && numbers[last + 1] == numbers[last] + 1) ++last;
    text += (text.empty() ? "" : ",") + std::to_string(numbers[n]);
    if (last > n) text += "-" + std::to_string(numbers[last]);
    n = last + 1;
  }
  return text;
}

std::filesystem::path write_engine_file(const std::filesystem::path& folder, const std::string& name,
                                        const std::string& text) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw UsageError(folder.string() + ": cannot be made: " + error.message());
  write_file_atomically(folder / name, text);
  return folder / name;
}

}  // namespace firn
