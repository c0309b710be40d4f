// SeparatedValues reads text tables row by row, as other programs write them: with comma, semicolon, tab or
// blanks, decimal points or commas, quoted fields, comments, missing values, and a line "sep=;" of
// spreadsheets.
#pragma once

#include <cstdint>
#include <deque>
#include <istream>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "files/text_lines.h"

namespace firn {

struct SeparatedRow {
  std::int64_t line = 0;            ///< in the file, from 1
  std::vector<std::string> fields;  ///< none of a blank line

  /// True also for a row of empty fields, as spreadsheets write blank lines.
  bool blank() const {
    for (const std::string& field : fields)
      if (!field.empty()) return false;
    return true;
  }
};

class SeparatedValues {
 public:
  /// Reads the first lines, which show the separator. @param longest_bytes of a line
  SeparatedValues(std::istream& in, const std::string& name, std::size_t longest_bytes = kLongestRowBytes);

  /// Reads the next row. Comments, from a # or % on a line of their
  /// own, are no rows. Returns false behind the last. @throws UsageError: a quote without end, a line too
  /// long
  bool next(SeparatedRow& row);

  /// Returns the number in a field, NaN of a missing value ("", "nan", "na", "n/a", "null", "none", "-").
  /// @param column for the message @throws UsageError naming file, line, column and text; also for a decimal
  /// comma in a file with decimal points
  double number(const SeparatedRow& row, std::size_t field, std::string_view column);
  /// The same; a missing value is an error, too.
  double finite_number(const SeparatedRow& row, std::size_t field, std::string_view column);
  /// True for a number, an infinite one, too, or a missing value: no name of a column.
  bool is_value(std::string_view field) const;

  /// Fields of the last comment before the first row: numpy.savetxt writes the names of columns there.
  std::vector<std::string> commented_names() const;
  double fraction(double file_bytes) const { return lines_.fraction(file_bytes); }
  /// @throws UsageError "<name>:<line>: <problem>"
  [[noreturn]] void fail(std::int64_t line, const std::string& problem) const;

  /// Longest row of a matrix: 100 000 numbers of 25 characters are 2.5 MB.
  static constexpr std::size_t kLongestRowBytes = std::size_t(1) << 23;

 private:
  struct Line {
    std::int64_t number = 0;
    std::string text;
  };
  struct Number {
    double value = 0.0;
    char mark = '\0';  ///< decimal point or comma; '\0' = a whole number, a missing value
  };

  void look_ahead();
  std::optional<Number> parsed(std::string_view field) const;
  void split(std::string_view text, std::vector<std::string>& fields, std::int64_t line) const;

  TextLines lines_;
  std::string name_, comment_;
  char separator_ = ',';
  std::deque<Line> ahead_;
  std::int64_t point_line_ = 0, comma_line_ = 0;  ///< first line with a decimal point or comma; 0 = none
};

}  // namespace firn
