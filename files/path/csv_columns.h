// csv_columns() reads the header of a CSV path file: the quantity and unit of each column.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

namespace firn {

struct CsvColumn {
  enum class Quantity { kX, kY, kZ, kSpeed, kYaw };
  Quantity quantity = Quantity::kX;
  std::string_view name;  ///< as the header spells it
  double scale = 1.0;     ///< to mm, mm/s or degrees
};

/// Headers that are read, for messages.
inline constexpr const char* kCsvHeaders =
    "x_mm,y_mm with or without speed_mm_s, yaw_deg and z_mm, in any order (also _um, _cm, _m, _in; _rad)";

/// The separator of a file's columns, by its first line: a comma, or a semicolon or a tab where there is
/// no comma.
char csv_separator(std::string_view text);

/// Returns nothing unless every name is known with its unit, none comes twice, and x and y are there.
/// `text` must outlive the names.
std::optional<std::vector<CsvColumn>> csv_columns(std::string_view text, char separator);

/// True if the first line of a file is numbers: a file without a header, whose columns are x_mm, y_mm and, if
/// there are three, z_mm.
bool csv_numbers(std::string_view text, char separator);

}  // namespace firn
