// ShardCommand is the command that prints one share of a study, as other programs start it on this computer
// or on others.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace firn {

struct ShardCommand {
  std::vector<std::string> words;  ///< program, command and options without --shard; paths are absolute
  int shards = 1;                  ///< of the study
  std::vector<int> wanted;         ///< numbers of those that have prints to do, ascending

  /// Returns the command of a shard for a POSIX shell. @param number what the shell puts in: "{}", "$K"
  std::string line(const std::string& number) const;
};

/// Returns numbers as ranges: "1-7,9".
std::string ranges_text(const std::vector<int>& numbers);

/// Writes a file of an engine below the study's folder. @throws UsageError: it cannot be written
std::filesystem::path write_engine_file(const std::filesystem::path& folder, const std::string& name,
                                        const std::string& text);

}  // namespace firn
