// Computes medians of unsorted values, by comparisons alone: same bytes on every machine.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace firn::statistics {

/// Standard deviation over median absolute deviation of a normal distribution.
inline constexpr double kMadToStd = 1.4826;

/// Returns the value at index size / 2 in ascending order: for an even count the upper of the middle two.
/// Reorders `v`. @pre not empty
template <class T>
T upper_median(std::vector<T>& v) {
  const auto middle = v.begin() + std::ptrdiff_t(v.size() / 2);
  std::nth_element(v.begin(), middle, v.end());
  return *middle;
}
template <class T>
T upper_median(std::vector<T>&& v) {
  return upper_median(v);
}

/// Returns the median: for an even count the mean of the middle two. Reorders `v`. @pre not empty
template <class T>
double median(std::vector<T>& v) {
  const double upper = double(upper_median(v));
  if (v.size() % 2 == 1) return upper;
  return 0.5 * (upper + double(*std::max_element(v.begin(), v.begin() + std::ptrdiff_t(v.size() / 2))));
}

}  // namespace firn::statistics
