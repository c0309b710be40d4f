// Range holds the interval of the values that an option may have.
#pragma once

#include <limits>
#include <string>

namespace firn {

struct Range {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  bool min_excluded = false;
  bool or_zero = false;  ///< 0, which switches the option off, is allowed beside the interval

  /// False for NaN and the infinities.
  constexpr bool holds(double value) const {
    const bool finite = value - value == 0.0;
    return finite &&
           ((or_zero && value == 0.0) || (value <= max && (min_excluded ? value > min : value >= min)));
  }
};

constexpr Range within(double min, double max) { return {min, max}; }
constexpr Range above(double min, double max) { return {min, max, true}; }
constexpr Range zero_or(double min, double max) { return {min, max, false, true}; }

/// "(0, 100]", "0 or [2, 1e+06]", or "" without a lower bound.
std::string text(const Range& range);

/// The shortest text that reads back to the same number: 3, 0.25, 1e+06.
std::string shortest_text(double value);

}  // namespace firn
