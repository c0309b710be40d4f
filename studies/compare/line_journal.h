// LineJournal reads and appends lines of a file that a crash must not spoil: each line carries its checksum,
// so that a torn or damaged one is left out.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace firn {

class LineJournal {
 public:
  /// Opens or makes the file and locks it.
  /// @param busy message where another process holds it
  /// @throws UsageError with `busy`, or naming the file and the reason
  LineJournal(const std::filesystem::path& path, const std::string& busy);
  ~LineJournal();
  LineJournal(const LineJournal&) = delete;
  LineJournal& operator=(const LineJournal&) = delete;

  struct Line {
    std::size_t number;  ///< from 1
    std::string text;    ///< without the checksum where it is right, else as it stands
    bool right;
  };
  /// Returns all lines but empty ones.
  std::vector<Line> lines();
  /// The same of a file that another process may be writing; a line at its end that is not whole yet is left
  /// out. @throws UsageError: it cannot be read
  static std::vector<Line> read(const std::filesystem::path& path);
  /// Appends with one write(), so that a line is whole or torn, never mixed with another.
  /// @pre no end of line in `text`
  /// @throws std::runtime_error naming the file: it cannot be written
  void append(std::string_view text);

 private:
  static std::vector<Line> lines_of(std::string_view text);

  std::filesystem::path path_;
  int fd_ = -1;
  bool torn_ = false;  ///< the file ends within a line
};

}  // namespace firn
