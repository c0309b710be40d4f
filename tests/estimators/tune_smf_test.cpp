#include "estimators/gains/tune_smf.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/grid/random.h"

using namespace firn;
using namespace firn::gains;
using control::smf_line::disturbance;
using control::smf_line::spread;

namespace {

constexpr Algorithm kAlgorithms[] = {Algorithm::kSlsqp, Algorithm::kLbfgs, Algorithm::kCobyla};
constexpr Gains kStarts[] = {{1.0, 1.0, 0.0}, {0.0, 0.0, 0.5}};

}  // namespace

TEST_CASE(
    "Table 5-2, errata: every algorithm finds K = [0.99990, 0.32798, 0.00005], sigma 0.060990, from both "
    "starts") {
  const auto d = disturbance({100, 0.5, 60, 0.2, 30});
  for (const Algorithm a : kAlgorithms)
    for (const Gains& start : kStarts) {
      INFO(name(a) << " from K_p = " << start.kp);
      const TunedGains t = tune_smf(d, {a, start});
      CHECK(std::abs(t.gains.kp - 0.99990) < 1e-5);
      CHECK(std::abs(t.gains.ki_star - 0.32798) < 1e-5);
      CHECK(std::abs(t.gains.kd_star - 0.00005) < 1e-5);
      CHECK(std::abs(t.rms - 0.060990) < 1e-6);
    }
}

TEST_CASE("5.6, errata: with d_s = 0.5 the optimum is [1, 0.618034, 0]") {
  const auto d = disturbance({100, 0.5, 60, 0.5, 30});
  for (const Algorithm a : kAlgorithms) {
    INFO(name(a));
    const TunedGains t = tune_smf(d, {a, {1.0, 1.0, 0.0}});
    CHECK(std::abs(t.gains.kp - 1.0) < 1e-5);
    CHECK(std::abs(t.gains.ki_star - 0.618034) < 1e-5);
    CHECK(std::abs(t.gains.kd_star) < 1e-5);
  }
}

TEST_CASE("Table 5-3: K_d* and sigma for each pulse, from both starts and by every algorithm") {
  struct Row {
    double pulse, kd, sigma;
  };
  for (const Row row :
       {Row{0.5, 0.0, 0.061}, Row{0.25, 0.023, 0.038}, Row{0.0, 0.126, 0.027}, Row{-0.5, 0.0, 0.061}})
    for (const double start : {0.0, 0.2})
      for (const Algorithm a : kAlgorithms) {
        INFO(name(a) << ", d_p = " << row.pulse << " from " << start);
        const TunedGains t =
            tune_smf(disturbance({100, row.pulse, 60, 0.2, 30}), {a, {1.0, 0.33, start}, true});
        CHECK(t.gains.kp == 1.0);
        CHECK(t.gains.ki_star == 0.33);
        CHECK(std::abs(t.gains.kd_star - row.kd) < 1e-3);
        CHECK(std::abs(t.rms - row.sigma) < 5e-4);
      }
}

TEST_CASE("Errata: at K_p = 1, K_d = 0 the best K_i* is -q + sqrt(q^2 + 2 q) with q = d_s^2 / (2 d_p^2)") {
  RandomStream random(21, Purpose::kTest);
  for (int trial = 0; trial < 20; ++trial) {
    const double dp = 0.2 + random.uniform(), ds = 0.2 + random.uniform();
    const auto d = disturbance({400, dp, 250, ds, 50});
    const double q = ds * ds / (2 * dp * dp), ki = -q + std::sqrt(q * q + 2 * q);
    const double sse = (2 * dp * dp * ki + ds * ds) / (ki * (2 - ki));
    const double rms = spread({1.0, ki, 0.0}, d).rms;
    CHECK(rms * rms * 400 == Approx(sse).epsilon(1e-9));
    CHECK(std::abs(spread({1.0, ki, 0.0}, d).gradient[1]) < 1e-9);
  }
}

TEST_CASE("Tuned gains are stable and no worse than 2,000 random stable ones, for random disturbances") {
  RandomStream random(22, Purpose::kTest);
  for (int trial = 0; trial < 10; ++trial) {
    std::vector<double> d(60);
    for (double& v : d) v = 0.2 + 0.6 * (random.uniform() - 0.5);
    const TunedGains t = tune_smf(d, {});
    CHECK(control::smf_line::stable(t.gains));
    for (int n = 0; n < 2000; ++n) {
      const Gains g{2 * random.uniform(), 4 * random.uniform(), random.uniform()};
      if (0.5 * g.kp + 0.25 * g.ki_star + g.kd_star < 1) CHECK(spread(g, d).rms >= t.rms - 1e-9);
    }
  }
}

TEST_CASE("No disturbance to tune for is refused") {
  CHECK_THROWS_AS(tune_smf({}, {}), std::invalid_argument);
  const std::vector<double> broken{0.1, NAN};
  CHECK_THROWS_AS(tune_smf(broken, {}), std::invalid_argument);
  const std::vector<double> d{0.1, 0.2};
  CHECK_THROWS_AS(tune_smf(d, {Algorithm::kSlsqp, {}, false, 0}), std::invalid_argument);
}
