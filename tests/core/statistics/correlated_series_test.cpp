#include "core/statistics/correlated_series.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "core/grid/random.h"

using namespace firn;
using namespace firn::statistics;

namespace {

/// A first-order autoregression of deviation 1 about 0.
std::vector<double> autoregression(std::uint64_t seed, int n, double memory) {
  std::vector<double> x;
  double value = random_normal({seed, Purpose::kTest, 0, 0, 0});
  for (int i = 1; i <= n; ++i) {
    x.push_back(value);
    value = memory * value +
            std::sqrt(1.0 - memory * memory) * random_normal({seed, Purpose::kTest, 0, 0, std::uint32_t(i)});
  }
  return x;
}

}  // namespace

TEST_CASE("Correlated layers are worth (1 - rho) / (1 + rho) of their number") {
  for (const double memory : {0.0, 0.65}) {
    double lag1 = 0.0, effective = 0.0;
    for (std::uint64_t seed = 1; seed <= 100; ++seed) {
      BootstrapOptions few;
      few.resamples = 10;
      const SeriesMean s = mean_of_series(autoregression(seed, 400, memory), few);
      lag1 += s.lag1 / 100;
      effective += s.effective / 100;
    }
    CHECK(lag1 == Approx(memory).margin(0.03));
    CHECK(effective == Approx(400 * (1.0 - memory) / (1.0 + memory)).epsilon(0.2));
  }
}

TEST_CASE(
    "The interval of correlated layers holds their mean as often as it says, where that of independent ones "
    "does not") {
  int held = 0, naive = 0;
  const int series = 300;
  for (int k = 0; k < series; ++k) {
    BootstrapOptions options;
    options.resamples = 300;
    options.seed = std::uint64_t(k + 1);
    const auto x = autoregression(1000 + std::uint64_t(k), 40, 0.65);
    const SeriesMean s = mean_of_series(x, options);
    held += s.interval.low <= 0.0 && s.interval.high >= 0.0;
    const Interval n = bootstrap_interval(x, options);
    naive += n.low <= 0.0 && n.high >= 0.0;
  }
  CHECK(held >= int(0.84 * series));
  CHECK(naive < int(0.75 * series));
}

TEST_CASE("Equal values have an interval of no width, and three have none") {
  const std::vector<double> equal(20, 3.5), few{1.0, 2.0, 3.0};
  CHECK(mean_of_series(equal).interval.low == 3.5);
  CHECK(mean_of_series(equal).interval.high == 3.5);
  CHECK(std::isnan(mean_of_series(few).interval.low));
  CHECK(mean_of_series(few).mean == 2.0);
}

TEST_CASE("The same series has the same interval, and a shifted one the shifted interval") {
  auto x = autoregression(5, 30, 0.5);
  const SeriesMean a = mean_of_series(x), again = mean_of_series(x);
  CHECK(a.interval.low == again.interval.low);
  for (double& v : x) v += 100.0;
  const SeriesMean b = mean_of_series(x);
  CHECK(b.interval.low == Approx(a.interval.low + 100.0).epsilon(1e-12));
  CHECK(b.effective == Approx(a.effective).epsilon(1e-9));
}
