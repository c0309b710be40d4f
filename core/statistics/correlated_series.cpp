#include "core/statistics/correlated_series.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/grid/random.h"
#include "core/statistics/distributions.h"

namespace firn::statistics {
namespace {

constexpr std::size_t kFewest = 4;  // values of which a correlation is taken

}  // namespace

SeriesMean mean_of_series(std::span<const double> x, const BootstrapOptions& options) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const std::size_t n = x.size();
  SeriesMean s;
  s.mean = mean(x);
  s.effective = double(n);
  s.interval = {kNan, kNan};
  if (n < kFewest) return s;
  const auto covariance = [&](std::size_t lag) {
    double sum = 0.0;
    for (std::size_t i = 0; i + lag < n; ++i) sum += (x[i] - s.mean) * (x[i + lag] - s.mean);
    return sum / double(n);
  };
  const double variance = covariance(0);
  if (!(variance > 0.0)) {
    s.interval = {s.mean, s.mean};
    return s;
  }
  s.lag1 = covariance(1) / variance;
  double sum = -1.0;  // of 2 rho_k from k = 0, the pairs of lags (0, 1), (2, 3), ... together
  for (std::size_t lag = 0; lag + 1 < n; lag += 2) {
    const double pair = (covariance(lag) + covariance(lag + 1)) / variance;
    if (pair <= 0.0) break;
    sum += 2.0 * pair;
  }
  // Deviations from a series' own mean correlate too little: by 1 / n at each lag, to first order.
  const double worth = std::max(1.0, sum / (1.0 - std::min(0.5, std::max(0.0, sum) / double(n))));
  s.effective = std::max(1.0, double(n) / worth);
  s.block = std::clamp(int(std::ceil(worth)), 1, int(n / 3 > 0 ? n / 3 : 1));

  const std::size_t blocks = (n + std::size_t(s.block) - 1) / std::size_t(s.block);
  RandomStream random(options.seed, Purpose::kBootstrap);
  double total = 0.0, squares = 0.0;
  for (int r = 0; r < options.resamples; ++r) {
    double drawn = 0.0;
    std::size_t taken = 0;
    for (std::size_t b = 0; b < blocks; ++b) {
      const std::size_t first = random.below(std::uint32_t(n));
      for (int k = 0; k < s.block && taken < n; ++k, ++taken) drawn += x[(first + std::size_t(k)) % n];
    }
    const double d = drawn / double(n) - s.mean;
    total += d;
    squares += d * d;
  }
  const double count = options.resamples;
  const double deviation = std::sqrt(std::max(0.0, squares / count - (total / count) * (total / count)));
  const double freedom = std::max(1.0, s.effective - 1.0);
  // A block's mean scatters about that of its own series, of which it is a part.
  const double part = 1.0 - double(s.block) / double(n);
  const double half = student_t_quantile(0.5 + 0.5 * options.confidence, freedom) * deviation *
                      std::sqrt((freedom + 1.0) / (freedom * part));
  s.interval = {s.mean - half, s.mean + half};
  return s;
}

}  // namespace firn::statistics
