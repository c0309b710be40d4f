// The shards of a study: the prints of each, and the journal files that they write into the folder
// `shards` of the study, one writer each.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "studies/compare/study_work.h"

namespace firn {

/// "3/40". @throws UsageError naming the text: not 1 <= K <= N <= 100,000
StudyShard parse_shard(std::string_view text);

/// Returns the prints of a shard, equal ones once. Each kind and part is dealt out print by print in the
/// order of the digests; where the time of each kind is known the longest come first, each to the shard that
/// has least. So all shards take as long, whoever makes them and whatever is on record. The order is that of
/// the work.
std::vector<const StudyCell*> cells_of(const StudyWork& work, const StudyShard& shard);

/// Returns the numbers, ascending, of the shards with a print that is not on record. @param of their number
std::vector<int> shards_to_do(const StudyWork& work, const StudyJournal& journal, int of);

/// The journal of one shard. While it is written its name ends in ".part"; a shard that was killed goes on
/// with it.
class ShardFile {
 public:
  ShardFile(const std::filesystem::path& study_folder, const StudyShard& shard);
  const std::filesystem::path& at_work() const { return at_work_; }
  /// Gives the file its name, since all prints of the shard are on record: "3-of-40.journal", or
  /// "3-of-40.2.journal" beside an earlier one. @returns the path
  /// @throws UsageError naming the file and the system's reason
  std::filesystem::path finish() const;

 private:
  std::filesystem::path stem_, at_work_;
};

/// Returns the path of a study's own journal.
std::filesystem::path results_journal(const std::filesystem::path& study_folder);
/// Adds the prints of all journals of a study to the one that is at work, whose own file is `except`.
void take_journals(StudyJournal& journal, const std::filesystem::path& study_folder,
                   const std::filesystem::path& except);

/// Returns the journals of all shards of a study folder, by name, those at work too.
std::vector<std::filesystem::path> shard_journals(const std::filesystem::path& study_folder);

}  // namespace firn
