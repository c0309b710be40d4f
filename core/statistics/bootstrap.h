// Computes bootstrap intervals of a mean, from keyed random numbers: the same data give the same interval
// everywhere.
#pragma once

#include <cstdint>
#include <span>

namespace firn::statistics {

double mean(std::span<const double> x);                ///< NaN for no values
double standard_deviation(std::span<const double> x);  ///< divisor n - 1; NaN for fewer than two values

struct Interval {
  double low = 0.0, high = 0.0;
};

struct BootstrapOptions {
  double confidence = 0.95;
  int resamples = 10'000;
  std::uint64_t seed = 1;
};

/// Bias-corrected and accelerated (BCa) interval of the mean [Efron and Tibshirani, An Introduction to the
/// Bootstrap, 1993, 14.3]. BCa and not the plain percentile interval, because paired differences of print
/// errors are skew, and BCa's coverage error falls as 1/n for skew data too, where the percentile's falls as
/// 1/sqrt(n). The nominal level is widened as [Hesterberg 2015, The American Statistician 69, "expanded
/// percentile"] has it: z_a becomes sqrt(n / (n-1)) t_{a, n-1}, without which ten values cover 90 % instead
/// of 95 %. All values equal: the interval is that value. Fewer than two values: NaN.
Interval bootstrap_interval(std::span<const double> x, const BootstrapOptions& options = {});

}  // namespace firn::statistics
