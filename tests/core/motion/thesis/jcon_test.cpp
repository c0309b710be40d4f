#include "core/motion/thesis/jcon.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/grid/random.h"

using namespace firn;
using namespace firn::motion;
using namespace firn::motion::thesis;

namespace {

/// Straight profile whose speed rises with 400 mm/s^2, then stays: one sudden loss of acceleration.
thesis::Profile ramp_and_hold() {
  thesis::Profile p;
  double s = 0;
  for (int i = 0; i <= 300; ++i) {
    p.points.push_back({s, 0});
    p.s_mm.push_back(s);
    s += 0.4;
  }
  for (int i = 0; i < 300; ++i) {
    const double c = std::min(100.0, std::sqrt(400.0 + 2 * 400 * 0.4 * (i + 0.5)));
    p.dt_s.push_back(0.4 / c);
  }
  p.speed_limit_mm_s.assign(300, 125);
  return p;
}

}  // namespace

TEST_CASE("(4.12): the cubic has the speeds and accelerations of both ends") {
  RandomStream random(41, Purpose::kTest);
  for (int i = 0; i < 1000; ++i) {
    const double v0 = random.uniform(0, 100), v1 = random.uniform(0, 100), a0 = random.uniform(-500, 500),
                 a1 = random.uniform(-500, 500), dt = random.uniform(0.01, 1);
    const CubicSpeed v = cubic_speed(v0, v1, a0, a1, dt);
    REQUIRE(v.at(0) == Approx(v0).margin(1e-9));
    REQUIRE(v.at(1) == Approx(v1).margin(1e-9));
    REQUIRE(v.b / dt == Approx(a0).margin(1e-6));
    REQUIRE((v.b + 2 * v.c + 3 * v.d) / dt == Approx(a1).margin(1e-6));
  }
}

TEST_CASE("Erratum Fig. 4-6: the time of an interval is the sum over k = l .. r - 1") {
  // Acceleration falls by 100 per point; intervals of 0.01 s: |a_r - a_l| = 100 (r - l), so the mean jerk is
  // 1e4 for any width; with one slow interval on the left it drops as soon as that interval is inside.
  std::vector<double> a, dt(20, 0.01);
  for (int i = 0; i <= 20; ++i) a.push_back(3000 - 100.0 * i);
  dt[7] = 1.0;
  const thesis::Interval got = grow({10, 11}, a, dt, 900, {0, 20});
  CHECK(got.left == 7);  // interval 7 runs from point 7 to point 8
  CHECK(got.right == 14);
}

TEST_CASE("Erratum Fig. 4-6: a side halts on a change of sign of its acceleration, not on a > 0") {
  std::vector<double> a{-100, -100, 300, 300, 300, -300, -300, -300, 50, 50}, dt(9, 0.01);
  const thesis::Interval got = grow({4, 5}, a, dt, 1.0, {0, 9});
  CHECK(got.left == 2);
  CHECK(got.right == 7);
}

TEST_CASE("Erratum Fig. 4-6: the test bounds the mean jerk only, the cubic's peak may exceed it") {
  const double dt = 0.1, a0 = 500, a1 = 110, v0 = 50, v1 = 60;  // mean jerk 3900 < 4000
  const CubicSpeed v = cubic_speed(v0, v1, a0, a1, dt);
  double peak = 0;
  for (double tau = 0; tau <= 1; tau += 0.01)
    peak = std::max(peak, std::abs(2 * v.c + 6 * v.d * tau) / (dt * dt));
  CHECK((a0 - a1) / dt < 4000);
  CHECK(peak > 4000);
}

TEST_CASE("Erratum (4.12): the cubic does not conserve arc length, so durations follow from distances") {
  const CubicSpeed v = cubic_speed(100, 100, 400, -400, 0.1);
  double length = 0;
  for (int i = 0; i < 1000; ++i) length += v.at((i + 0.5) / 1000) * 1e-4;
  CHECK(length != Approx(100 * 0.1).epsilon(0.01));
  thesis::Profile p = ramp_and_hold();
  const std::vector<double> s = p.s_mm;
  jcon(p, {.position = {125, 500, 4000}}, {});
  CHECK(p.s_mm == s);  // the path is covered all the same
}

TEST_CASE("JCON spreads a sudden loss of acceleration and only ever takes longer") {
  thesis::Profile p = ramp_and_hold();
  const thesis::Profile before = p;
  const auto worst = [](const thesis::Profile& q) {
    double most = 0;
    for (const double j : rates(q.s_mm, q.dt_s).jerk) most = std::min(most, j);
    return -most;
  };
  jcon(p, {.position = {125, 500, 4000}}, {});
  for (std::size_t k = 0; k < p.dt_s.size(); ++k) REQUIRE(p.dt_s[k] >= before.dt_s[k]);
  CHECK(worst(before) > 40000);
  CHECK(worst(p) < worst(before) / 5);
}

TEST_CASE("A smooth profile is left alone") {
  thesis::Profile p = ramp_and_hold();
  p.dt_s.assign(300, 0.01);
  const auto dt = p.dt_s;
  jcon(p, {.position = {125, 500, 4000}}, {});
  CHECK(p.dt_s == dt);
}
