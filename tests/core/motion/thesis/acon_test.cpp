#include "core/motion/thesis/acon.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/grid/random.h"
#include "core/motion/thesis/sections.h"

using namespace firn;
using namespace firn::motion;
using namespace firn::motion::thesis;

namespace {

const RateLimits kAconLimits{125, 500, 4000};

Ladder even(std::size_t intervals, double ds, double radius = kUnlimited) {
  return {std::vector<double>(intervals, ds), std::vector<double>(intervals + 1, radius)};
}

}  // namespace

TEST_CASE(
    "Erratum 4.1.3: jerk 4000, a0 = 500, v0 = 10, ds = 0.4 has three real roots, one of them positive") {
  const auto f = [](double t) { return 4000.0 / 6 * t * t * t + 250 * t * t + 10 * t - 0.4; };
  int changes = 0;
  for (double t = -1.0; t < 1.0; t += 1e-3) changes += (f(t) < 0) != (f(t + 1e-3) < 0);
  CHECK(changes == 3);
  const double root = time_over_distance(4000, 500, 10, 0.4);
  CHECK(root > 0.0);
  CHECK(std::abs(f(root)) < 1e-12);
}

TEST_CASE("(4.7): the time found is the only positive root, for any positive jerk, acceleration and speed") {
  RandomStream random(31, Purpose::kTest);
  for (int i = 0; i < 20000; ++i) {
    const double j = std::exp(random.uniform(-5, 10)), a = random.below(4) ? random.uniform(0, 1000) : 0.0;
    const double v = random.below(4) ? random.uniform(0, 200) : 0.0, d = std::exp(random.uniform(-20, 3));
    const double t = time_over_distance(j, a, v, d);
    REQUIRE(t > 0.0);
    REQUIRE(((j / 6 * t + a / 2) * t + v) * t == Approx(d).epsilon(1e-9));
  }
  CHECK(time_over_distance(4000, 0, 0, 0) == 0.0);
}

TEST_CASE("Erratum Fig. 4-5: the entry replaced is dt_i, from i to i + 1, and the update uses dt_i and c_i") {
  std::vector<double> dt(10, 1e-3);
  acceleration_curve(even(10, 0.4), {4, 10.0, 0.0}, +1, 10, kAconLimits, dt);
  CHECK(dt[3] == 1e-3);
  // From 10 mm/s with constant jerk the motion over every point is 10 t + j t^3 / 6 until a reaches 500 at
  // 0.125 s.
  double t = 0;
  for (std::size_t k = 4; k < 10; ++k) {
    t += dt[k];
    if (t < 0.125) CHECK(10 * t + 4000 * t * t * t / 6 == Approx(0.4 * double(k - 3)).epsilon(1e-9));
  }
}

TEST_CASE("Erratum Fig. 4-5: the curve ends where it is faster than the envelope (then f <- 0)") {
  std::vector<double> dt(100, 0.4 / 60);  // envelope 60 mm/s
  dt[0] = 0.4 / 20;
  CHECK(acceleration_curve(even(100, 0.4), {1, 20.0, 0.0}, +1, 100, kAconLimits, dt));
  std::size_t met = 1;
  while (met < 100 && dt[met] > 0.4 / 60) ++met;
  CHECK(met > 5);
  CHECK(met < 40);
  for (std::size_t k = met; k < 100; ++k) CHECK(dt[k] == 0.4 / 60);
  for (std::size_t k = 1; k < met; ++k) CHECK(dt[k] <= dt[k - 1] * (1 + 1e-12));
}

TEST_CASE("Erratum Fig. 4-5: with a_r above the limit, a_t is zero and the speed stays, never NaN") {
  std::vector<double> dt(20, 1e-4);
  acceleration_curve(even(20, 0.4, 1.0), {0, 50.0, 0.0}, +1, 20, kAconLimits, dt);  // 2500 mm/s^2 radial
  for (const double t : dt) CHECK(t == Approx(0.4 / 50));
  std::vector<double> rest(20, 1e-4);
  acceleration_curve(even(20, 0.4, 1.0), {0, 0.0, 0.0}, +1, 20, kAconLimits, rest);
  for (const double t : rest) CHECK((std::isfinite(t) && t > 0));
}

TEST_CASE("A curve backwards is the mirror of the curve forwards") {
  std::vector<double> forward(50, 1e-3), backward(50, 1e-3);
  acceleration_curve(even(50, 0.4, 30.0), {0, 15.0, 100.0}, +1, 50, kAconLimits, forward);
  acceleration_curve(even(50, 0.4, 30.0), {50, 15.0, 100.0}, -1, 0, kAconLimits, backward);
  for (std::size_t k = 0; k < 50; ++k) CHECK(forward[k] == backward[49 - k]);
}

TEST_CASE("On a bend the tangential part shrinks so that the total acceleration keeps its limit") {
  std::vector<double> dt(200, 1e-4);
  acceleration_curve(even(200, 0.1, 20.0), {0, 20.0, 0.0}, +1, 200, kAconLimits, dt);
  double c = 20.0;
  for (std::size_t k = 0; k < 200; ++k) {
    const double next = 2 * 0.1 / dt[k] - c, tangential = (next - c) / dt[k], radial = c * c / 20;
    CHECK(std::sqrt(tangential * tangential + radial * radial) <= 500 * 1.05);
    c = next;
  }
}

TEST_CASE("ACON leaves no acceleration above its margin in a straight dip of the envelope") {
  std::vector<Point2> points;
  thesis::Profile p;
  for (int i = 0; i <= 500; ++i) {
    p.points.push_back({0.4 * i, 0});
    p.s_mm.push_back(0.4 * i);
  }
  p.dt_s.assign(500, 0.4 / 125);
  p.speed_limit_mm_s.assign(500, 125);
  p.dt_s[250] = p.dt_s[251] = 0.4 / 10;
  const std::vector<double> envelope = p.dt_s;
  acon(p, {.position = kAconLimits}, {});
  const auto total = total_rates(p).acceleration;
  for (std::size_t i = 0; i < total.size(); ++i) CHECK(total[i] <= 1.1 * 500);
  for (std::size_t k = 0; k < envelope.size(); ++k) CHECK(p.dt_s[k] >= envelope[k]);
  CHECK(p.dt_s[250] == envelope[250]);  // the slowest place stays
}

TEST_CASE("Erratum 4.2.4: the pair of margins is of acceleration, 10 %, and of jerk, 20 %") {
  // A straight that gains speed at a constant rate after a start with constant jerk: both just under or over.
  const auto changed = [](double acceleration, double jerk) {
    thesis::Profile p;
    double s = 0, c = 30, a = 0;
    for (int i = 0; i <= 100; ++i) {
      p.points.push_back({s, 0});
      p.s_mm.push_back(s);
      if (i == 100) break;
      s += c * 0.004 + a * 0.004 * 0.004 / 2;
      c += a * 0.004;
      a = std::min(acceleration, a + jerk * 0.004);
      p.dt_s.push_back(0.004);
      p.speed_limit_mm_s.push_back(1e9);
    }
    const auto before = p.dt_s;
    acon(p, {.position = kAconLimits}, {});
    return p.dt_s != before;
  };
  CHECK_FALSE(changed(1.08 * 500, 1.15 * 4000));
  CHECK(changed(1.12 * 500, 1.15 * 4000));
  CHECK(changed(0.5 * 500, 1.25 * 4000));
}

TEST_CASE("Joints are treated in sections of one sign of their rate") {
  const auto parts = sections({0, 1, 2, 2, 1, 0, 3});
  REQUIRE(parts.size() == 3);
  CHECK(parts[0].last == 3);
  CHECK(parts[1].sign == -1);
  CHECK(parts[2].first == 5);
  CHECK(sections({1, 1, 1}).size() == 1);
}
