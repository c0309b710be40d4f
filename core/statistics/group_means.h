// Computes means over groups that are resampled too, and their intervals.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/statistics/bootstrap.h"

namespace firn::statistics {

/// Hierarchical bootstrap interval of the mean of group means: groups are drawn, then values within each
/// [Davison and Hinkley, Bootstrap Methods and their Application, 1997, 3.8]. By percentiles, widened for few
/// groups as bootstrap_interval() is for few values. Groups without a value count for nothing. Fewer than two
/// groups: NaN.
Interval hierarchical_interval(std::span<const std::vector<double>> groups,
                               const BootstrapOptions& options = {});
/// The mean of the means of the groups that have a value; NaN without one.
double mean_of_groups(std::span<const std::vector<double>> groups);

}  // namespace firn::statistics
