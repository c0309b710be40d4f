// StudyJournal holds the prints of a study that are on record: one line for each, appended to
// results.journal, or to the file of a shard, when the print is over. A line that was torn by a crash, or
// damaged, is detected by its checksum and printed anew; the others count.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_set>
#include <vector>

#include "studies/compare/line_journal.h"
#include "studies/compare/study_lab.h"

namespace firn {

/// Holds the identity of a print before it is made: indices, and the digest of its resolved experiment,
/// inputs, seed and lab of the seed. Program and platform stand beside it (StudyOrigin).
struct StudyCell {
  std::size_t arm = 0, part = 0, seed = 0;  ///< indices
  std::string digest;
};

/// Program and platform that made a print: results of others are kept and do not count.
struct StudyOrigin {
  std::string build;     ///< of sources and compiler, 16 hexadecimal digits
  std::string platform;  ///< digest of the fingerprint of results, likewise
  bool operator==(const StudyOrigin&) const = default;
};
/// Returns that of this process.
StudyOrigin study_origin();

/// Platforms whose results count. Unlike computers that give the same results are one platform.
enum class StudyPlatforms { kThis, kAny };

class StudyJournal {
 public:
  /// Opens or makes the journal and locks it. @throws UsageError naming file and reason: another study is at
  /// work there, no file can be opened
  /// @param values numbers of each result
  StudyJournal(const std::filesystem::path& path, std::span<const report::StudyMetric> values,
               StudyPlatforms platforms = StudyPlatforms::kThis, const StudyOrigin& origin = study_origin());
  /// A record that no file keeps: it reads other journals, at whatever their writers are, and locks none.
  explicit StudyJournal(std::span<const report::StudyMetric> values,
                        StudyPlatforms platforms = StudyPlatforms::kThis,
                        const StudyOrigin& origin = study_origin());

  /// From now on take() passes over the prints of all other cells: a shard needs to know its own.
  void take_only(const std::vector<const StudyCell*>& cells);
  /// Adds the prints of another journal, which its writer may be appending to; those on record stay.
  /// @throws UsageError: the file cannot be read
  void take(const std::filesystem::path& journal);

  const StudyPrint* find(const std::string& digest) const;
  std::size_t size() const { return prints_.size(); }  ///< prints on record, of any settings
  /// Lines of a file that were torn or damaged, or are of another study's values, and do not count.
  struct Damage {
    std::filesystem::path file;
    std::size_t lines = 0, first = 0;  ///< their number; the first one's, from 1
  };
  const std::vector<Damage>& damage() const { return damage_; }
  std::size_t damaged() const;                                      ///< lines that do not count
  std::size_t of_other_builds() const { return of_other_builds_; }  ///< lines that do not count
  std::size_t of_other_platforms() const {
    return of_other_platforms_;
  }  ///< lines, whether they count or not
  /// Bytes of a result on record, on average [B]; of one print of many metrics where there is none.
  double line_bytes() const;
  /// Adds a result, to the file too if there is one. @throws std::runtime_error naming the file: it cannot be
  /// written
  void append(const std::string& digest, std::string_view arm, std::string_view part, std::uint64_t seed,
              const StudyPrint& print);

 private:
  void add(const std::filesystem::path& file, const std::vector<LineJournal::Line>& lines, bool newer);

  std::vector<std::string> values_;
  StudyPlatforms platforms_;
  StudyOrigin origin_;
  std::optional<LineJournal> lines_;
  std::size_t bytes_ = 0, lines_read_ = 0;
  std::vector<Damage> damage_;
  std::size_t of_other_builds_ = 0, of_other_platforms_ = 0;
  std::optional<std::unordered_set<std::string>> only_;
  std::map<std::string, StudyPrint> prints_;
};

}  // namespace firn
