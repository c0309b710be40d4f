#include "core/statistics/sign_flip.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <vector>

#include "core/grid/random.h"
#include "core/statistics/grouped.h"

namespace firn::statistics {

double sign_flip_p(std::span<const double> sample, const SignFlipOptions& o) {
  const std::vector<double> d = grouped(sample);
  double sum = 0.0, size = 0.0;
  for (const double v : d) {
    sum += v;
    size += std::abs(v);
  }
  if (!(size > 0.0)) return 1.0;
  const double reach = std::abs(sum) - 1e-12 * size;  // patterns that tie but for rounding count as ties

  if (d.size() <= o.all_up_to) {  // Gray code: one sign changes from pattern to pattern
    const std::uint64_t patterns = std::uint64_t(1) << d.size();
    std::vector<double> sign(d.size(), 1.0);
    std::uint64_t hits = 0;
    double s = sum;
    for (std::uint64_t n = 1; n <= patterns; ++n) {
      hits += std::abs(s) >= reach;
      if (n == patterns) break;
      const std::size_t k = std::size_t(std::countr_zero(n));
      s -= 2.0 * sign[k] * d[k];
      sign[k] = -sign[k];
    }
    return double(hits) / double(patterns);
  }

  // The sum of eight values under each pattern of their signs is looked up: bit 1 is plus.
  constexpr std::size_t kByte = 8, kPatterns = 1u << kByte, kBlock = 128;
  const std::size_t bytes = (d.size() + kByte - 1) / kByte;
  std::vector<double> sums(bytes * kPatterns);
  for (std::size_t b = 0; b < bytes; ++b)
    for (std::size_t pattern = 0; pattern < kPatterns; ++pattern)
      for (std::size_t q = b * kByte; q < std::min(d.size(), (b + 1) * kByte); ++q)
        sums[b * kPatterns + pattern] += pattern >> (q % kByte) & 1u ? d[q] : -d[q];
  const std::array<std::uint32_t, 2> key{std::uint32_t(o.seed), std::uint32_t(o.seed >> 32)};
  int hits = 0;
  for (int n = 0; n < o.draws; ++n) {
    double s = 0.0;
    for (std::size_t b = 0; b < bytes; b += kBlock / kByte) {
      const PhiloxBlock bits = philox4x32(
          {std::uint32_t(b * kByte), 1, std::uint32_t(n), std::uint32_t(Purpose::kBootstrap)}, key);
      for (std::size_t q = b; q < std::min(bytes, b + kBlock / kByte); ++q)
        s += sums[q * kPatterns + (bits[(q - b) / 4] >> (kByte * (q % 4)) & (kPatterns - 1))];
    }
    hits += std::abs(s) >= reach;
  }
  return (1.0 + hits) / (1.0 + o.draws);
}

double smallest_p(std::size_t pairs, const SignFlipOptions& o) {
  if (pairs == 0) return 1.0;
  return pairs <= o.all_up_to ? 2.0 / double(std::uint64_t(1) << pairs) : 1.0 / (1.0 + o.draws);
}

}  // namespace firn::statistics
