// Groups of a long sample: resampling needs time that grows with the sample, and gains nothing beyond some
// thousand values.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace firn::statistics {

/// Samples up to this are resampled value by value. With so many the standard deviation of a mean is known to
/// 2.2 % (1 / sqrt(2 n)).
inline constexpr std::size_t kMostGroups = 1024;

/// Returns the means of groups of equally many values, in order; the last group may be smaller. Values that
/// are independent and alike have group means that are too, with the same mean, the same standard deviation
/// of it, and the same acceleration (skewness / 6 sqrt(n)). A sample of at most kMostGroups values is
/// returned as it is.
inline std::vector<double> grouped(std::span<const double> x) {
  const std::size_t size = (x.size() + kMostGroups - 1) / kMostGroups;
  if (size <= 1) return {x.begin(), x.end()};
  std::vector<double> means;
  for (std::size_t at = 0; at < x.size(); at += size) {
    const std::size_t end = at + size < x.size() ? at + size : x.size();
    double sum = 0.0;
    for (std::size_t n = at; n < end; ++n) sum += x[n];
    means.push_back(sum / double(end - at));
  }
  return means;
}

}  // namespace firn::statistics
