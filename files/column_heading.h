// ColumnHeading splits the name of a table's column into a word and a unit: "Height [um]", "height (um)",
// "height_um" and "height um" are the height in um.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace firn {

struct ColumnHeading {
  std::string word, unit;  ///< lower case; a unit is mm, mm_s, deg, ...; "" = none named
  bool bracketed = false;  ///< a unit in brackets may be unknown
};
ColumnHeading heading_of(std::string_view name);

/// Names of the units of length, for messages.
inline constexpr const char* kLengthUnits = "mm, um, nm, cm, m, in, mil";
/// Returns millimetres per unit of a length; "um", "µm", "micron" and others have several names.
std::optional<double> length_unit_mm(std::string_view unit);
/// Returns mm/s per unit of a speed: "mm_s", "cm_min", ...
std::optional<double> speed_unit_mm_s(std::string_view unit);

}  // namespace firn
