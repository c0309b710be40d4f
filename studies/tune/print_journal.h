// PrintJournal remembers simulated prints in a file, so that an interrupted firn tune goes on where it was:
// the same call asks for the same prints, and those on record are not made again.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "runtime/node.h"
#include "studies/compare/line_journal.h"
#include "studies/tune/lab_print.h"

namespace firn::tune {

class PrintJournal {
 public:
  /// Opens or makes the file. A line that was cut short when its writer was killed does not count.
  /// @throws UsageError naming file, line and key: it is no file or cannot be written, another firn tune is
  /// at work with it, a line is damaged or no simulated print
  explicit PrintJournal(const std::filesystem::path& file);

  /// Returns the digest of everything that decides a print's result, this program's commit included.
  static std::string digest_of(const Experiment& experiment, const Blobs& inputs, const LabDraw& draw,
                               const LabPrintOptions& wanted);

  std::optional<LabPrint> find(const std::string& digest);
  void append(const std::string& digest, const LabPrint& print);
  std::size_t known() const { return known_; }      ///< prints on record when it was opened
  std::size_t damaged() const { return damaged_; }  ///< lines that were cut short

 private:
  LineJournal lines_;
  std::size_t known_ = 0, damaged_ = 0;
  std::mutex lock_;
  std::map<std::string, LabPrint> prints_;
};

}  // namespace firn::tune
