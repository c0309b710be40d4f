// csv_columns() reads the names of the columns of a CSV path file: the quantity and unit of each.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace firn {

struct CsvColumn {
  enum class Quantity { kX, kY, kZ, kSpeed, kYaw, kIndex };
  Quantity quantity = Quantity::kX;
  std::string name;      ///< as the header spells it
  double scale = 1.0;    ///< to mm, mm/s or degrees
  bool assumed = false;  ///< no unit is named: mm
};

/// Headers that are read, for messages.
inline constexpr const char* kCsvHeaders =
    "x_mm,y_mm with or without speed_mm_s, yaw_deg and z_mm, in any order (also _um, _cm, _m, _in; _rad)";

/// A first column without a name is the index of its rows, as pandas writes it.
/// @param fail throws an error with the given problem: a name or unit that is not known, one that comes
/// twice, no x or no y
std::vector<CsvColumn> csv_columns(const std::vector<std::string>& names,
                                   const std::function<void(const std::string&)>& fail);

}  // namespace firn
