// StudyJournal writes and reads results.journal of a study folder: one line for each print, appended when the
// print is over. A line that was torn by a crash, or damaged, is detected by its checksum and printed anew;
// the others count.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "studies/compare/line_journal.h"
#include "studies/compare/study_lab.h"

namespace firn {

/// Holds the identity of a print before it is made: indices, and the digest of all inputs that decide its
/// result.
struct StudyCell {
  std::size_t arm = 0, part = 0, seed = 0;  ///< indices
  std::string digest;
};

class StudyJournal {
 public:
  /// Opens or makes the journal and locks it. @throws UsageError naming file and reason: another study is at
  /// work there, no file can be opened
  StudyJournal(const std::filesystem::path& path, const StudyLab& lab);

  const StudyPrint* find(const std::string& digest) const;
  std::size_t size() const { return prints_.size(); }  ///< prints on record, of any settings
  std::size_t damaged() const { return damaged_; }     ///< lines that do not count
  void append(const std::string& digest, std::string_view arm, std::string_view part, std::uint64_t seed,
              const StudyPrint& print);

 private:
  const StudyLab& lab_;
  LineJournal lines_;
  std::size_t damaged_ = 0;
  std::map<std::string, StudyPrint> prints_;
};

}  // namespace firn
