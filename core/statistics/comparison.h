// Computes the paired comparison of two samples: mean difference, interval, p-value and effect size.
#pragma once

#include <cstddef>
#include <span>

#include "core/statistics/bootstrap.h"

namespace firn::statistics {

struct PairedComparison {
  std::size_t pairs = 0;
  double mean_a = 0.0, mean_b = 0.0;
  double difference = 0.0;  ///< mean of a - b
  Interval interval;        ///< of the difference, BCa
  double p = 1.0;           ///< sign-flip test, two-sided
  double effect = 0.0;  ///< d_z: mean / standard deviation of the paired differences [Cohen 1988]; 0 if all
                        ///< are 0, infinite if all are equal and not 0
  double a_below_b = 0.5;  ///< share of pairs with a < b; ties count half
};

/// @param a, b same length, a[k] and b[k] of one pair; finite.
PairedComparison compare_pairs(std::span<const double> a, std::span<const double> b,
                               const BootstrapOptions& options = {});

}  // namespace firn::statistics
