#include "core/statistics/holm.h"

#include <algorithm>
#include <cstddef>
#include <numeric>

namespace firn::statistics {

std::vector<double> holm(std::span<const double> p) {
  std::vector<std::size_t> order(p.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return p[a] < p[b]; });
  std::vector<double> adjusted(p.size());
  double so_far = 0.0;
  for (std::size_t n = 0; n < order.size(); ++n) {
    so_far = std::max(so_far, std::min(1.0, double(p.size() - n) * p[order[n]]));
    adjusted[order[n]] = so_far;
  }
  return adjusted;
}

}  // namespace firn::statistics
