#include "core/statistics/group_means.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/grid/random.h"
#include "core/statistics/distributions.h"
#include "core/statistics/grouped.h"

namespace firn::statistics {
namespace {

constexpr double kNoInterval = std::numeric_limits<double>::quiet_NaN();

// Words 0, 1, 2, ... of one resample.
class KeyedDraws {
 public:
  KeyedDraws(std::uint64_t seed, std::uint32_t resample)
      : key_{std::uint32_t(seed), std::uint32_t(seed >> 32)}, resample_(resample) {}
  /// An index below n.
  std::size_t below(std::size_t n) {
    if (at_ % 4 == 0) block_ = philox4x32({at_, 2, resample_, std::uint32_t(Purpose::kBootstrap)}, key_);
    return std::size_t((block_[at_++ % 4] * std::uint64_t(n)) >> 32);
  }

 private:
  std::array<std::uint32_t, 2> key_;
  std::uint32_t resample_, at_ = 0;
  PhiloxBlock block_{};
};

std::vector<std::vector<double>> with_values(std::span<const std::vector<double>> groups) {
  std::vector<std::vector<double>> out;
  for (const auto& g : groups)
    if (!g.empty()) out.push_back(grouped(g));
  return out;
}

}  // namespace

double mean_of_groups(std::span<const std::vector<double>> groups) {
  std::vector<double> means;
  for (const auto& g : groups)
    if (!g.empty()) means.push_back(mean(g));
  return mean(means);
}

Interval hierarchical_interval(std::span<const std::vector<double>> all, const BootstrapOptions& o) {
  const std::vector<std::vector<double>> groups = with_values(all);
  if (groups.size() < 2) return {kNoInterval, kNoInterval};
  std::vector<double> means(std::size_t(o.resamples), 0.0);
  for (std::size_t b = 0; b < means.size(); ++b) {
    KeyedDraws draws(o.seed, std::uint32_t(b));
    for (std::size_t g = 0; g < groups.size(); ++g) {
      const std::vector<double>& x = groups[draws.below(groups.size())];
      double sum = 0.0;
      for (std::size_t n = 0; n < x.size(); ++n) sum += x[draws.below(x.size())];
      means[b] += sum / double(x.size());
    }
    means[b] /= double(groups.size());
  }
  std::sort(means.begin(), means.end());
  const double n = double(groups.size());
  const double z = std::sqrt(n / (n - 1.0)) * student_t_quantile(0.5 * (1.0 - o.confidence), n - 1.0);
  const auto quantile_at = [&](double p) {
    const double at = std::clamp(p * double(means.size() + 1) - 1.0, 0.0, double(means.size() - 1));
    const std::size_t below = std::size_t(at), above = std::min(below + 1, means.size() - 1);
    return means[below] + (at - double(below)) * (means[above] - means[below]);
  };
  return {quantile_at(normal_cdf(z)), quantile_at(normal_cdf(-z))};
}

}  // namespace firn::statistics
