// The certified planner against closed forms, computed references and the evidence of its own samples.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "core/grid/random.h"
#include "core/motion/curve/deviation.h"
#include "core/motion/planner.h"
#include "core/motion/thesis/test_path.h"
#include "tests/core/motion/random_paths.h"
#include "tests/support/long_cases.h"

namespace firn::motion {
namespace {

using thesis::fig_4_2;

std::vector<Point2> line(double length, int chords) {
  std::vector<Point2> points;
  for (int i = 0; i <= chords; ++i) points.push_back({length * i / chords, 0.0});
  return points;
}

PlanResult plan_at(const std::vector<Point2>& points, Point2 origin, const PlanOptions& options = {},
                   const MotionLimits& limits = cobra600_limits()) {
  static const auto arm = make_scara(cobra600());
  PathInput input;
  input.points = points;
  input.origin = origin;
  return plan(input, *arm, limits, options);
}

double largest_ratio(const PlanResult& result) {
  double most = 0.0;
  for (const LimitRatio& limit : result.trajectory.certificate.limits) most = std::max(most, limit.ratio);
  return most;
}

/// Largest of the nine ratios by differences of the samples alone, computed here.
double outsider_ratio(const PlanResult& result) {
  const double degree = std::numbers::pi / 180.0, h = result.trajectory.tick_s;
  const double limit[3][3] = {{125, 500, 4000},
                              {33 * degree, 165 * degree, 1320 * degree},
                              {39 * degree, 195 * degree, 1560 * degree}};
  double most = 0.0;
  const std::size_t n = result.trajectory.samples();
  const auto joint = [&](std::size_t i, std::size_t j) { return result.trajectory.positions[i * 4 + j]; };
  for (std::size_t i = 0; i + 3 < n; ++i) {
    for (int k = 0; k < 3; ++k) {
      const auto d = [&](auto f) {
        const double a = f(i), b = f(i + 1), c = f(i + 2), e = f(i + 3);
        return k == 0   ? (b - a) / h
               : k == 1 ? (c - 2 * b + a) / (h * h)
                        : (e - 3 * c + 3 * b - a) / (h * h * h);
      };
      const double x = d([&](std::size_t m) { return result.tool[m].x_mm; }),
                   y = d([&](std::size_t m) { return result.tool[m].y_mm; });
      most = std::max(most, std::hypot(x, y) / limit[0][k]);
      for (std::size_t j = 0; j < 2; ++j)
        most = std::max(most, std::abs(d([&](std::size_t m) { return joint(m, j); })) / limit[j + 1][k]);
    }
  }
  return most;
}

PlanOptions with(Method method, double tolerance_mm = 0.0) {
  PlanOptions options;
  options.method = method;
  options.tolerance_mm = tolerance_mm;
  return options;
}

}  // namespace

TEST_CASE("A straight 100 mm from rest to rest takes L/v + v/a + a/j and 74 ticks") {
  const PlanResult result = plan_at(line(100.0, 250), {304.0, 0.0});
  REQUIRE(result.ok());
  CHECK(std::abs(result.continuous_s - (100.0 / 125 + 125.0 / 500 + 500.0 / 4000)) < 1e-9);
  CHECK(result.trajectory.samples() == 75);
  CHECK(std::abs(result.trajectory.certificate.duration_s - 1.184) < 1e-12);
  CHECK(largest_ratio(result) <= 1.0);
}

TEST_CASE("Straight lines of any length take the closed form's time, whichever limits they reach") {
  // v not reached: v (v/a + a/j) = L; a not reached: T = 4 (L / 2j)^(1/3)
  const auto time = [](double length) { return plan_at(line(length, 7), {330.0, 0.0}).continuous_s; };
  const double v = 0.5 * 500.0 * (std::sqrt(0.125 * 0.125 + 4.0 * 30.0 / 500.0) - 0.125);
  CHECK(std::abs(time(30.0) - 2.0 * (v / 500.0 + 0.125)) < 1e-9);
  CHECK(std::abs(time(2.0) - 4.0 * std::cbrt(2.0 / 8000.0)) < 1e-9);
  CHECK(std::abs(time(0.01) - 4.0 * std::cbrt(0.01 / 8000.0)) < 1e-9);
}

TEST_CASE("The test path of Fig. 4-2 is planned within 2 percent of the computed optimum, both placements") {
  const PlanResult well = plan_at(fig_4_2(), thesis::kWellPlaced),
                   poor = plan_at(fig_4_2(), thesis::kPoorlyPlaced);
  REQUIRE(well.ok());
  REQUIRE(poor.ok());
  CHECK(well.trajectory.certificate.duration_s <= 5.268);
  CHECK(poor.trajectory.certificate.duration_s <= 6.224);
  for (const PlanResult* result : {&well, &poor}) {
    CHECK(largest_ratio(*result) <= 1.001);
    CHECK(outsider_ratio(*result) <= 1.001);
    CHECK(result->stops == 1);
    CHECK(result->deviation_mm < 0.006);  // w^2 / (24 R) + the chords' sagitta at R = 5 mm
    CHECK(result->trajectory.certificate.lower_bound_s < result->continuous_s);
  }
}

TEST_CASE("The slow tier comes within 0.2 percent of the computed optimum") {
  const PlanResult well = plan_at(fig_4_2(), thesis::kWellPlaced, with(Method::kOptimal));
  const PlanResult poor = plan_at(fig_4_2(), thesis::kPoorlyPlaced, with(Method::kOptimal));
  REQUIRE(well.ok());
  REQUIRE(poor.ok());
  CHECK(well.continuous_s <= 1.002 * 5.165059);
  CHECK(poor.continuous_s <= 1.002 * 6.102257);
  CHECK(largest_ratio(well) <= 1.001);
  CHECK(largest_ratio(poor) <= 1.001);
  CHECK(well.trajectory.certificate.lower_bound_s < 5.165059);
  CHECK(poor.trajectory.certificate.lower_bound_s < 6.102257);
  CHECK(well.trajectory.certificate.lower_bound_s > 0.88 * 5.165059);
}

TEST_CASE("The lower bound lies below the duration, also under a very low speed limit") {
  static const auto arm = make_scara(cobra600());
  const std::vector<Point2> points = line(100.0, 250);
  for (const double speed_limit : {0.5, 5.0, 50.0, 1000.0}) {
    PathInput input;
    input.points = points;
    input.origin = {304.0, 0.0};
    input.speed_limit.path_mm_s = speed_limit;
    const PlanResult result = plan(input, *arm, cobra600_limits());
    REQUIRE(result.ok());
    const double v = std::min(speed_limit, 125.0), without_jerk = 100.0 / v + v / 500.0;
    const double exact = 100.0 / v + (v < 62.5 ? 2.0 * std::sqrt(v / 4000.0) : v / 500.0 + 0.125);
    CHECK(result.trajectory.certificate.lower_bound_s <= exact * (1.0 + 1e-9));
    CHECK(result.trajectory.certificate.lower_bound_s > 0.99 * without_jerk);
  }
}

TEST_CASE("With 0.05 mm of tolerance the test path takes at most 4.643 s and stays inside the tolerance") {
  const PlanResult result = plan_at(fig_4_2(), thesis::kWellPlaced, with(Method::kCertified, 0.05));
  REQUIRE(result.ok());
  CHECK(result.trajectory.certificate.duration_s <= 4.643);
  CHECK(result.deviation_mm <= 0.05);
  CHECK(largest_ratio(result) <= 1.001);
  CHECK(outsider_ratio(result) <= 1.001);
}

TEST_CASE("With a tolerance no random path leaves it, and none that keeps it anyway becomes slower") {
  const auto arm = make_scara(cobra600());
  RandomPathMaker maker(9);
  PlanWorkspace work;
  double exact_s = 0.0, within_s = 0.0;
  std::vector<RandomPath> paths;
  for (int k = 0; k < 150; ++k) paths.push_back(maker.next());
  for (const std::size_t k : test::long_cases(paths.size(), 15)) {
    const RandomPath& path = paths[k];
    PathInput input;
    input.points = path.points;
    const PlanResult exact = plan(input, *arm, cobra600_limits(), {}, work);
    const PlanResult within = plan(input, *arm, cobra600_limits(), with(Method::kCertified, 0.05), work);
    INFO("path " << k << " (" << path.kind << ", " << path.points.size() << " points)");
    REQUIRE(exact.ok() == within.ok());
    if (!exact.ok()) continue;
    exact_s += exact.continuous_s;
    within_s += within.continuous_s;
    CHECK(within.deviation_mm <= 0.05);
    CHECK(largest_ratio(within) <= 1.001);
    if (exact.deviation_mm <= 0.05) CHECK(within.continuous_s <= exact.continuous_s * (1.0 + 1e-9));
  }
  CHECK(within_s < 0.97 * exact_s);
}

TEST_CASE(
    "More tolerance never slows a gear's rings down, and 0.01 mm costs little beside ramps that leave it") {
  const auto arm = make_scara(cobra600());
  PlanWorkspace work;
  double exact_s = 0.0, hundredth_s = 0.0;
  std::vector<double> radii_mm = test::long_cases<double>({50.0, 42.0, 25.0}, 0);
  radii_mm.insert(radii_mm.end(), {8.0, 3.0});
  for (const double radius_mm : radii_mm) {
    std::vector<Point2> ring;  // uneven chords, as the slicer's: close together on the flanks of the teeth
    const int n = int(60.0 + 4.0 * radius_mm);
    for (int i = 0; i < n; ++i) {
      const double a = 2.0 * std::numbers::pi * i / n,
                   r = radius_mm + 0.06 * radius_mm * std::tanh(1.5 * std::cos(12.0 * a));
      ring.push_back({r * std::cos(a), r * std::sin(a)});
    }
    PathInput input;
    input.points = ring;
    input.closed = true;
    input.origin = {380.0, 0.0};
    const PlanResult exact = plan(input, *arm, cobra600_limits(), {}, work);
    REQUIRE(exact.ok());
    double before_s = 1e300;
    for (const double tolerance_mm : {0.002, 0.005, 0.01, 0.02, 0.05, 0.1}) {
      const PlanResult within =
          plan(input, *arm, cobra600_limits(), with(Method::kCertified, tolerance_mm), work);
      INFO("radius " << radius_mm << " mm, tolerance " << tolerance_mm << " mm; without "
                     << exact.continuous_s << " s, " << exact.deviation_mm << " mm");
      REQUIRE(within.ok());
      CHECK(within.deviation_mm <= tolerance_mm);
      CHECK(within.continuous_s <= 1.01 * before_s);
      CHECK(largest_ratio(within) <= 1.001);
      if (exact.deviation_mm <= tolerance_mm) CHECK(within.continuous_s <= 1.002 * exact.continuous_s);
      before_s = within.continuous_s;
      if (tolerance_mm != 0.01) continue;
      CHECK(exact.deviation_mm > tolerance_mm);
      exact_s += exact.continuous_s;
      hundredth_s += within.continuous_s;
    }
  }
  CHECK(hundredth_s < 1.2 * exact_s);
}

TEST_CASE(
    "Vertices that scatter by micrometres are smoothed within the tolerance, and the path takes half the "
    "time") {
  RandomStream draw(77, Purpose::kTest);
  const auto flower = [&](double noise_mm, int n) {
    std::vector<Point2> points;
    for (int i = 0; i <= n; ++i) {
      const double a = 2.0 * std::numbers::pi * i / n, r = 30.0 + 2.0 * std::sin(5.0 * a);
      points.push_back({r * std::cos(a) + noise_mm * draw.uniform(-1.0, 1.0),
                        r * std::sin(a) + noise_mm * draw.uniform(-1.0, 1.0)});
    }
    return points;
  };
  const double clean_s = plan_at(flower(0.0, 500), {380, 0}).continuous_s;
  for (const double noise_mm : {0.002, 0.005, 0.02}) {
    const std::vector<Point2> points = flower(noise_mm, 500);
    const PlanResult exact = plan_at(points, {380, 0}),
                     smooth = plan_at(points, {380, 0}, with(Method::kCertified, 0.05));
    INFO("noise " << noise_mm << ": " << exact.continuous_s << " and " << smooth.continuous_s
                  << " s, without noise " << clean_s);
    REQUIRE(smooth.ok());
    CHECK(smooth.continuous_s < 0.6 * exact.continuous_s);
    CHECK(smooth.continuous_s < 1.35 * clean_s);
    CHECK(smooth.deviation_mm <= 0.05);
    CHECK(deviation(smooth.tool, points) <= 0.05);
    CHECK(largest_ratio(smooth) <= 1.001);
    CHECK(outsider_ratio(smooth) <= 1.001);
  }
  // a run between two lines that are given as such: the lines stay
  std::vector<Point2> mixed{{0.0, 0.0}, {20.0, 0.0}};
  for (int i = 1; i < 60; ++i)
    mixed.push_back({20.0 + 0.4 * i, 2.0 * std::pow(std::sin(0.5 * std::numbers::pi * i / 60), 4) +
                                         draw.uniform(-0.003, 0.003)});
  for (const double x : {44.0, 64.0}) mixed.push_back({x, 2.0});
  const PlanResult exact = plan_at(mixed, {350, 0}),
                   smooth = plan_at(mixed, {350, 0}, with(Method::kCertified, 0.05));
  REQUIRE(smooth.ok());
  CHECK(smooth.continuous_s < exact.continuous_s);
  CHECK(smooth.deviation_mm <= 0.05);
  CHECK(largest_ratio(smooth) <= 1.001);
  for (const Point2& p : smooth.tool) {
    if (p.x_mm < 18.0) CHECK(std::abs(p.y_mm) < 0.01);
    if (p.x_mm > 46.0) CHECK(std::abs(p.y_mm - 2.0) < 0.01);
  }
}

TEST_CASE(
    "No limit is exceeded on random paths, by the differences of samples 32 times finer than the tick") {
  const auto arm = make_scara(cobra600());
  RandomPathMaker maker(20121105);
  PlanWorkspace work;
  PlanOptions options;
  options.tick_s = 0.0005;
  int planned = 0;
  for (int k = 0; k < 400; ++k) {
    const RandomPath path = maker.next();
    PathInput input;
    input.points = path.points;
    const PlanResult result = plan(input, *arm, cobra600_limits(), options, work);
    INFO("path " << k << " (" << path.kind << ", " << path.points.size() << " points)");
    if (!result.ok()) {
      INFO(describe(*result.fault));
      CHECK((result.fault->reason == Reason::kJointLow || result.fault->reason == Reason::kJointHigh));
      continue;
    }
    ++planned;
    CHECK(largest_ratio(result) <= 1.001);
    CHECK(outsider_ratio(result) <= 1.001);
  }
  CHECK(planned > 350);
}

TEST_CASE(
    "Near full reach, where joints join while the profile is being solved, the fast tier stays near the slow "
    "one") {
  for (const double reach : {540.0, 560.0, 570.0}) {
    std::vector<Point2> points;
    for (int i = 0; i <= 320; ++i) {
      const double a = 2.0 * std::numbers::pi * i / 320,
                   r = 18.0 + 2.0 * std::cos(3.0 * a) + std::cos(5.0 * a);
      points.push_back({r * std::cos(a), r * std::sin(a)});
    }
    const PlanResult fast = plan_at(points, {reach, 0}),
                     slow = plan_at(points, {reach, 0}, with(Method::kOptimal));
    REQUIRE(fast.ok());
    REQUIRE(slow.ok());
    INFO(reach << " mm: " << fast.continuous_s << " and " << slow.continuous_s << " s");
    CHECK(fast.continuous_s < 1.03 * slow.continuous_s);
    CHECK(largest_ratio(fast) <= 1.001);
    CHECK(outsider_ratio(fast) <= 1.001);
    CHECK(fast.trajectory.certificate.lower_bound_s < slow.continuous_s);
  }
}

TEST_CASE("At a very low speed limit the speed is steady between the knots too, and rests stay short") {
  std::vector<Point2> arc;
  for (int i = 0; i <= 400; ++i) arc.push_back({30.0 * std::cos(0.014 * i), 30.0 * std::sin(0.014 * i)});
  static const auto arm = make_scara(cobra600());
  PathInput input;
  input.points = arc;
  input.origin = {380.0, 0.0};
  input.speed_limit.path_mm_s = 0.6;
  const PlanResult result = plan(input, *arm, cobra600_limits());
  REQUIRE(result.ok());
  const double length = 30.0 * 5.6;
  CHECK(result.continuous_s < length / 0.6 + 1.0);
  const double h = result.trajectory.tick_s;
  std::size_t slow = 0;
  for (std::size_t n = 0; n + 1 < result.tool.size(); ++n) {
    const double speed = std::hypot(result.tool[n + 1].x_mm - result.tool[n].x_mm,
                                    result.tool[n + 1].y_mm - result.tool[n].y_mm) /
                         h;
    CHECK(speed <= 0.6 * 1.001);
    if (speed < 0.59) ++slow;
  }
  CHECK(double(slow) * h < 4.0);
}

TEST_CASE("Bad input comes back as a named reason") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto reason = [](const PlanResult& r) { return r.fault ? r.fault->reason : Reason::kNoSolution; };
  CHECK(reason(plan_at({{0, 0}, {nan, 1}}, {350, 0})) == Reason::kNotFinite);
  CHECK(reason(plan_at({{0, 0}}, {350, 0})) == Reason::kTooFewPoints);
  CHECK(reason(plan_at({{0, 0}, {0, 0}}, {350, 0})) == Reason::kTooFewPoints);
  CHECK(reason(plan_at(line(100.0, 10), {555, 0})) == Reason::kReachFar);
  MotionLimits limits = cobra600_limits();
  limits.position.jerk = -1.0;
  CHECK(reason(plan_at(line(10.0, 10), {350, 0}, {}, limits)) == Reason::kLimitNotPositive);
  PlanOptions options;
  options.tick_s = 0.0;
  CHECK(reason(plan_at(line(10.0, 10), {350, 0}, options)) == Reason::kOption);
}

}  // namespace firn::motion
