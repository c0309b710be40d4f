// SeparatedValues reads text tables as other programs write them: comma, semicolon or tab, quoted fields,
// comments, decimal commas, missing values.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace firn {

struct SeparatedRow {
  std::size_t line = 0;  ///< in the file, from 1
  std::vector<std::string> fields;
};

class SeparatedValues {
 public:
  /// @param text may begin with a byte order mark and end lines with CR LF @throws UsageError: a quote
  /// without end, naming `name` and line
  SeparatedValues(std::string_view text, const std::string& name);

  const std::vector<SeparatedRow>& rows() const { return rows_; }

  /// Returns the number in a field, NaN of a missing value ("", "nan", "na", "n/a", "null", "none", "-").
  /// @throws UsageError naming file, line and field
  double number(const SeparatedRow& row, std::size_t field) const;
  /// Returns true if the first row holds a field that is neither a number nor missing.
  bool has_header() const;

 private:
  std::optional<double> parsed(std::string_view field) const;

  std::string name_;
  char separator_ = ',';
  std::vector<SeparatedRow> rows_;
};

}  // namespace firn
