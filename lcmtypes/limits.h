// Limit holds the range of a message member, Relation a condition between members: generated from the
// comments of the .lcm files. For validate.cpp.
#pragma once

#include <span>
#include <string_view>

namespace firn {

struct Limit {
  std::string_view type, path;
  double low, high;
  bool above_low = false;      ///< low itself is refused
  bool nan_ok = false;         ///< arrays: NaN means not measured
  std::string_view when = {};  ///< the row holds only while this member lies in [when_low, when_high]
  double when_low = 0, when_high = 0;
};
/// Of the rows without `when` the first that fits a member decides; rows with `when` hold besides it.
std::span<const Limit> limits();

/// A condition between members.
struct Relation {
  enum class Kind : unsigned char {
    kCells,        ///< a = b * c
    kCellsOrNone,  ///< a = b * c, or a = 0
    kLess,         ///< a < b
    kNotAbove,     ///< a <= b, element by element
    kAllNotAbove,  ///< no element of array a above b
  };
  std::string_view type;
  Kind kind;
  std::string_view a, b, c = {};
  std::string_view when = {};
  double when_low = 0, when_high = 0;
};
std::span<const Relation> relations();

/// Largest text in a message [bytes].
inline constexpr std::size_t kMaxTextBytes = std::size_t(1) << 20;

}  // namespace firn
