// Computes ratios of paired values: their geometric mean with an interval, over one group or over groups
// that are resampled too, and a bound for non-inferiority.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/statistics/bootstrap.h"

namespace firn::statistics {

/// Ratios a / b of pairs, whose logarithms are averaged.
struct RatioSummary {
  std::size_t pairs = 0;
  double ratio = 1.0;  ///< geometric mean; NaN without a pair
  Interval interval;   ///< of the ratio, BCa; NaN for fewer than two pairs
  double p = 1.0;      ///< sign-flip test of the logarithms, two-sided
  double upper = 0.0;  ///< one-sided 95 % bound of the ratio: the upper end of the 90 % BCa interval
};
/// @param logs ln(a / b) of each pair, finite
RatioSummary ratio_of(std::span<const double> logs, const BootstrapOptions& options = {});

/// Hierarchical bootstrap interval of the mean of group means: groups are drawn, then values within each
/// [Davison and Hinkley, Bootstrap Methods and their Application, 1997, 3.8]. By percentiles, widened for few
/// groups as bootstrap_interval() is for few values. Groups without a value count for nothing. Fewer than two
/// groups: NaN.
Interval hierarchical_interval(std::span<const std::vector<double>> groups,
                               const BootstrapOptions& options = {});
/// The mean of the means of the groups that have a value; NaN without one.
double mean_of_groups(std::span<const std::vector<double>> groups);

}  // namespace firn::statistics
