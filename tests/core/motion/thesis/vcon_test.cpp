#include "core/motion/thesis/vcon.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/motion/thesis/pathsplit.h"
#include "core/motion/thesis/test_path.h"

using namespace firn;
using namespace firn::motion;
using namespace firn::motion::thesis;

namespace {

thesis::Profile circle(double radius, double spacing) {
  std::vector<Point2> points;
  for (int i = 0; i * spacing < 3 * radius; ++i)
    points.push_back({radius * std::cos(i * spacing / radius), radius * std::sin(i * spacing / radius)});
  PathInput in{.points = points};
  return redistribute(clean(in), 0, points.size() - 1, {.spacing_mm = spacing});
}

double middle_speed(const thesis::Profile& p) {
  const std::size_t k = p.dt_s.size() / 2;
  return (p.s_mm[k + 1] - p.s_mm[k]) / p.dt_s[k];
}

RateLimits only_acceleration(double a) { return {1e9, a, 1e12}; }

}  // namespace

TEST_CASE("Erratum (4.9): the speed limit of a round is sqrt(a_max r_c), not sqrt(a_max / r_c)") {
  for (const double radius : {1.0, 5.0, 20.0}) {
    thesis::Profile p = circle(radius, radius / 200);
    vcon(p, {.position = only_acceleration(500)});
    CHECK(middle_speed(p) == Approx(std::sqrt(500 * radius)).epsilon(1e-3));
  }
  // At 1 mm, where the thesis quotes 25 mm/s, which needs 625 mm/s^2.
  const auto speed_at_1_mm = [](double a_mm_s2) {
    thesis::Profile p = circle(1.0, 1.0 / 200);
    vcon(p, {.position = only_acceleration(a_mm_s2)});
    return middle_speed(p);
  };
  CHECK(speed_at_1_mm(500) == Approx(22.4).margin(0.05));
  CHECK(speed_at_1_mm(625) == Approx(25.0).epsilon(1e-3));
}

TEST_CASE(
    "Erratum 4.1.2: the total differences D2s, D3s contain the curvature, the tangential D2s, D3s do not") {
  thesis::Profile p = circle(10.0, 0.1);
  p.dt_s.assign(p.size() - 1, 0.1 / 50);  // 50 mm/s
  const TotalRates total = total_rates(p);
  const Rates tangential = rates(p.s_mm, p.dt_s);
  const std::size_t k = p.size() / 2;
  const double c = (p.s_mm[1] - p.s_mm[0]) / p.dt_s[0];
  CHECK(total.acceleration[k] == Approx(c * c / 10.0).epsilon(1e-3));
  CHECK(total.jerk[k] == Approx(c * c * c / 100.0).epsilon(1e-3));
  CHECK(tangential.acceleration[k] == Approx(0.0).margin(1e-6));
  CHECK(tangential.jerk[k] == Approx(0.0).margin(1e-3));
}

TEST_CASE("Erratum (4.2), (4.5): the third rows bound the jerk, so a round's speed is (j r^2)^(1/3)") {
  thesis::Profile p = circle(5.0, 0.02);
  vcon(p, {.position = {1e9, 1e12, 4000}});
  CHECK(middle_speed(p) == Approx(std::cbrt(4000 * 25.0)).epsilon(1e-3));
}

TEST_CASE("Erratum (4.5): the bound divides the root of the squares, it does not stand under it") {
  const std::vector<Point2> diagonal{{0, 0}, {3, 4}, {6, 8}, {9, 12}, {12, 16}};
  std::vector<double> dt(4, 0.0);
  impose_position(diagonal, {100, 1e9, 1e9}, dt);
  for (const double t : dt) CHECK(t == Approx(5.0 / 100));  // not sqrt(25 / 100)
}

TEST_CASE("Erratum (4.4): every joint has its own bound") {
  thesis::Profile p = circle(5.0, 0.1);
  const std::size_t n = p.size();
  p.joints.assign(2, std::vector<double>(n, 0.0));
  for (std::size_t i = 0; i < n; ++i) p.joints[1][i] = 0.01 * double(i);  // the second joint alone moves
  MotionLimits limits{.position = {1e9, 1e12, 1e12}};
  limits.joint[0] = {1e-3, 1e-3, 1e-3};
  limits.joint[1] = {2.0, 1e9, 1e9};
  vcon(p, limits);
  for (const double dt : p.dt_s) CHECK(dt == Approx(0.01 / 2.0));
}

TEST_CASE("Erratum (4.4), (4.5): the envelope drops q' s-double-dot and is no bound on acceleration") {
  // On a straight line the envelope knows no acceleration at all: with a speed limit that steps, it jumps.
  const std::vector<Point2> points{{0, 0}, {10, 0}, {20, 0}};
  PathInput in{.points = points};
  in.speed_limit.point_mm_s = {20, 20, 120};
  thesis::Profile p = redistribute(clean(in), 0, 2, {});
  vcon(p, {.position = {125, 500, 4000}});
  double most = 0;
  for (const double a : total_rates(p).acceleration) most = std::max(most, a);
  in.speed_limit.point_mm_s = {20, 20, 20};
  CHECK(most < 1e-6);  // both segments end at the slow point
  in.speed_limit.point_mm_s.clear();
  p = redistribute(clean(in), 0, 2, {});
  for (std::size_t k = 0; k < p.speed_limit_mm_s.size(); ++k)
    p.speed_limit_mm_s[k] = k < p.speed_limit_mm_s.size() / 2 ? 20 : 120;
  vcon(p, {.position = {125, 500, 4000}});
  most = 0;
  for (const double a : total_rates(p).acceleration) most = std::max(most, a);
  CHECK(most > 10 * 500);
}

TEST_CASE(
    "Erratum, curvature jumps: the envelope's speed at a line-arc junction comes from the sampling alone") {
  // Third differences see half the jump over each of two intervals: c^3 = 2 j r ds, so finer sampling is
  // slower.
  for (const double ds : {0.1, 0.2, 0.4, 0.8}) {
    std::vector<Point2> points;
    for (int i = -100; i <= 100; ++i) {
      const double s = i * ds, angle = s / 20.0;
      points.push_back(i <= 0 ? Point2{s, 0} : Point2{20 * std::sin(angle), 20 - 20 * std::cos(angle)});
    }
    std::vector<double> dt(points.size() - 1, 0.0);
    impose_position(points, {1e9, 1e12, 4000}, dt);
    CHECK(ds / dt[100] == Approx(std::cbrt(2 * 4000 * 20.0 * ds)).epsilon(0.02));
  }
}

TEST_CASE("A speed limit caps the envelope along the path and per interval") {
  const auto path = thesis::fig_4_2();
  PathInput in{.points = path};
  in.speed_limit.path_mm_s = 50;
  for (thesis::Profile& p : pathsplit(clean(in), {})) {
    vcon(p, {.position = {125, 500, 4000}});
    for (std::size_t i = 0; i + 1 < p.size(); ++i)
      CHECK((p.s_mm[i + 1] - p.s_mm[i]) / p.dt_s[i] <= 50 * (1 + 1e-12));
  }
}
