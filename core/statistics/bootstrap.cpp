#include "core/statistics/bootstrap.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/grid/random.h"
#include "core/statistics/distributions.h"
#include "core/statistics/grouped.h"

namespace firn::statistics {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

std::vector<double> resampled_means(std::span<const double> x, const BootstrapOptions& o) {
  const std::array<std::uint32_t, 2> key{std::uint32_t(o.seed), std::uint32_t(o.seed >> 32)};
  const std::uint64_t n = x.size();
  std::vector<double> means(std::size_t(o.resamples), 0.0);
  for (std::uint32_t b = 0; b < means.size(); ++b) {
    double sum = 0.0;
    for (std::uint32_t k = 0; k < n; k += 4) {
      const PhiloxBlock draw = philox4x32({k, 0, b, std::uint32_t(Purpose::kBootstrap)}, key);
      for (std::uint32_t q = 0; q < std::min<std::uint64_t>(4, n - k); ++q) sum += x[(draw[q] * n) >> 32];
    }
    means[b] = sum / double(n);
  }
  std::sort(means.begin(), means.end());
  return means;
}

// Quantile of sorted values by linear interpolation between the order statistics at p (B + 1).
double quantile(const std::vector<double>& sorted, double p) {
  const double at = std::clamp(p * double(sorted.size() + 1) - 1.0, 0.0, double(sorted.size() - 1));
  const std::size_t below = std::size_t(at);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return sorted[below] + (at - double(below)) * (sorted[above] - sorted[below]);
}

}  // namespace

double mean(std::span<const double> x) {
  double sum = 0.0;
  for (const double v : x) sum += v;
  return x.empty() ? kNaN : sum / double(x.size());
}

double standard_deviation(std::span<const double> x) {
  if (x.size() < 2) return kNaN;
  const double m = mean(x);
  double square = 0.0;
  for (const double v : x) square += (v - m) * (v - m);
  return std::sqrt(square / double(x.size() - 1));
}

Interval bootstrap_interval(std::span<const double> sample, const BootstrapOptions& o) {
  if (sample.size() < 2) return {kNaN, kNaN};
  const std::vector<double> x = grouped(sample);
  if (std::all_of(x.begin(), x.end(), [&](double v) { return v == x[0]; })) return {x[0], x[0]};
  const double m = mean(x), n = double(x.size()), resamples = double(o.resamples);
  const std::vector<double> means = resampled_means(x, o);

  const auto below = std::lower_bound(means.begin(), means.end(), m),
             above = std::upper_bound(means.begin(), means.end(), m);
  const double share = (double(below - means.begin()) + 0.5 * double(above - below)) / resamples;
  const double bias =
      normal_quantile(std::clamp(share, 1.0 / (resamples + 1.0), resamples / (resamples + 1.0)));
  double square = 0.0, cube = 0.0;
  for (const double v : x) {
    square += (v - m) * (v - m);
    cube += (v - m) * (v - m) * (v - m);
  }
  const double acceleration = cube / (6.0 * square * std::sqrt(square));

  const double z = std::sqrt(n / (n - 1.0)) * student_t_quantile(0.5 * (1.0 - o.confidence), n - 1.0);
  const auto level = [&](double side) {
    const double w = bias + side;
    return normal_cdf(bias + w / std::max(1e-3, 1.0 - acceleration * w));
  };
  return {quantile(means, level(z)), quantile(means, level(-z))};
}

}  // namespace firn::statistics
