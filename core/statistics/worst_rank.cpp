#include "core/statistics/worst_rank.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace firn::statistics {

std::vector<double> signed_worst_ranks(std::span<const PairOutcome> pairs) {
  const auto size = [&](std::size_t k) {
    const PairOutcome& p = pairs[k];
    return p.stops != 0.0 ? std::pair(std::abs(p.stops), 0.0) : std::pair(0.0, std::abs(p.difference));
  };
  std::vector<std::size_t> order(pairs.size());
  std::iota(order.begin(), order.end(), std::size_t(0));
  std::erase_if(order, [&](std::size_t k) { return size(k) == std::pair(0.0, 0.0); });
  std::sort(order.begin(), order.end(), [&](std::size_t x, std::size_t y) { return size(x) < size(y); });
  std::vector<double> ranks(pairs.size(), 0.0);
  for (std::size_t first = 0; first < order.size();) {
    std::size_t end = first + 1;
    while (end < order.size() && size(order[end]) == size(order[first])) ++end;
    const double rank = 0.5 * double(first + 1 + end);  // mean of first + 1 .. end
    for (std::size_t n = first; n < end; ++n) {
      const PairOutcome& p = pairs[order[n]];
      ranks[order[n]] = (p.stops != 0.0 ? p.stops : p.difference) > 0.0 ? rank : -rank;
    }
    first = end;
  }
  return ranks;
}

}  // namespace firn::statistics
