// RatioSummary is the geometric mean of paired ratios with its interval, and a bound for non-inferiority.
#pragma once

#include <cstddef>
#include <span>

#include "core/statistics/bootstrap.h"

namespace firn::report {

/// Ratios a / b of pairs, whose logarithms are averaged.
struct RatioSummary {
  std::size_t pairs = 0;
  double ratio = 1.0;             ///< geometric mean; NaN without a pair
  statistics::Interval interval;  ///< of the ratio, BCa; NaN for fewer than two pairs
  double p = 1.0;                 ///< sign-flip test of the logarithms, two-sided
  double upper = 0.0;  ///< one-sided 95 % bound of the ratio: the upper end of the 90 % BCa interval
};
/// @param logs ln(a / b) of each pair, finite
RatioSummary ratio_of(std::span<const double> logs, const statistics::BootstrapOptions& options = {});

}  // namespace firn::report
