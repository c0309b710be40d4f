#include "core/statistics/comparison.h"

#include <limits>
#include <vector>

#include "core/statistics/sign_flip.h"

namespace firn::statistics {

PairedComparison compare_pairs(std::span<const double> a, std::span<const double> b,
                               const BootstrapOptions& options) {
  PairedComparison c;
  c.pairs = a.size();
  c.mean_a = mean(a);
  c.mean_b = mean(b);
  std::vector<double> d(a.size());
  double below = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    d[k] = a[k] - b[k];
    below += d[k] < 0.0 ? 1.0 : d[k] == 0.0 ? 0.5 : 0.0;
  }
  c.difference = mean(d);
  c.interval = bootstrap_interval(d, options);
  SignFlipOptions flips;
  flips.seed = options.seed;
  c.p = sign_flip_p(d, flips);
  const double deviation = standard_deviation(d);
  c.effect = c.difference == 0.0 ? 0.0
             : deviation > 0.0   ? c.difference / deviation
                               : (c.difference > 0.0 ? 1.0 : -1.0) * std::numeric_limits<double>::infinity();
  if (!a.empty()) c.a_below_b = below / double(a.size());
  return c;
}

}  // namespace firn::statistics
