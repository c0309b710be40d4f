// Interval of a value by leaving one group of the data out: groups are independent, what lies inside one is
// not.
#pragma once

#include <span>

namespace firn::statistics {

struct LeftOneOut {
  double mean = 0.0;        ///< of the values without each group
  double half_width = 0.0;  ///< of the 95 % interval
};

/// Delete-one-group jackknife [Efron and Stein, Ann. Stat. 9 (1981) 586]: variance = (n - 1) / n sum of (x_i
/// - mean)^2 over the values x_i that are found without group i; Student's t of n - 1. Of a mean over groups
/// that is the usual interval of the mean.
/// @param without one value for each group, two at least
/// @throws std::invalid_argument: fewer than two
LeftOneOut leave_one_out(std::span<const double> without);

}  // namespace firn::statistics
