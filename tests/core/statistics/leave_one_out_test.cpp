#include "core/statistics/leave_one_out.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "core/grid/random.h"
#include "core/statistics/distributions.h"

using namespace firn;
using namespace firn::statistics;

TEST_CASE("Leaving one group out of a mean gives the mean's usual interval") {
  RandomStream random(3, Purpose::kTest);
  for (const std::size_t n : {2u, 3u, 8u, 40u}) {
    std::vector<double> x(n);
    double sum = 0.0, squares = 0.0;
    for (double& v : x) sum += v = random.normal();
    for (const double v : x) squares += (v - sum / double(n)) * (v - sum / double(n));
    std::vector<double> without;
    for (const double v : x) without.push_back((sum - v) / double(n - 1));
    const LeftOneOut r = leave_one_out(without);
    CHECK(r.mean == Approx(sum / double(n)).margin(1e-12));
    const double usual = student_t_95(double(n - 1)) * std::sqrt(squares / double(n - 1) / double(n));
    CHECK(r.half_width == Approx(usual));
  }
}

TEST_CASE("The interval by leaving one run out holds a planted mean in 95 % of samples of correlated runs") {
  int covered = 0;
  constexpr int kSamples = 2000, kRuns = 6, kLayers = 20;
  RandomStream random(11, Purpose::kTest);
  for (int k = 0; k < kSamples; ++k) {
    std::vector<double> of_run(kRuns, 0.0);
    double all = 0.0;
    for (double& mean : of_run) {
      double layer = random.normal();
      for (int n = 0; n < kLayers; ++n) {
        layer = 0.7 * layer + std::sqrt(1.0 - 0.49) * random.normal();
        mean += layer / kLayers;
      }
      all += mean;
    }
    std::vector<double> without;
    for (const double mean : of_run) without.push_back((all - mean) / (kRuns - 1));
    const LeftOneOut r = leave_one_out(without);
    covered += std::abs(r.mean) <= r.half_width;
  }
  CHECK(covered > 0.935 * kSamples);
  CHECK(covered < 0.965 * kSamples);
}

TEST_CASE("One group alone has no interval by leaving it out") {
  const double one = 1.0;
  CHECK_THROWS_WITH(leave_one_out({&one, 1}), Catch::Contains("two groups"));
}
