// Time depends on the curve and the tolerance, not on how the path was sampled.
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "core/motion/planner.h"
#include "core/path/rounding.h"
#include "tests/core/motion/sampled_curves.h"

namespace firn::motion {
namespace {

PlanResult plan_curve(const std::vector<Point2>& points, double tolerance_mm,
                      Method method = Method::kCertified) {
  static const auto arm = make_scara(cobra600());
  static PlanWorkspace work;
  PathInput input;
  input.points = points;
  input.origin = {400.0, 0.0};
  PlanOptions options;
  options.method = method;
  options.tolerance_mm = tolerance_mm;
  options.point_noise_mm = rounding_mm(points);
  PlanResult result = plan(input, *arm, cobra600_limits(), options, work);
  INFO((result.ok() ? std::string() : describe(*result.fault)));
  REQUIRE(result.ok());
  for (const LimitRatio& limit : result.trajectory.certificate.limits) CHECK(limit.ratio <= 1.0);
  if (tolerance_mm > 0.0) CHECK(result.deviation_mm <= tolerance_mm);
  return result;
}

ParametricCurve ellipse(double a, double b) {
  return [=](double t) {
    const double w = 2.0 * std::numbers::pi * t;
    return Point2{a * std::cos(w), b * std::sin(w)};
  };
}

ParametricCurve rose() {
  return [](double t) {
    const double w = 2.0 * std::numbers::pi * t, r = 20.0 + 6.0 * std::cos(5.0 * w);
    return Point2{r * std::cos(w), r * std::sin(w)};
  };
}

}  // namespace

TEST_CASE("The lower bound is below the slow tier's motion on every kind of curve, and near it in the mean") {
  double sum = 0.0;
  int curves = 0;
  for (int kind = 0; kind < kCurveKinds; ++kind)
    for (const std::uint64_t seed : {11, 12, 13}) {
      INFO(kCurveKind[kind] << " " << seed);
      const PlanResult r = plan_curve(sampled(random_curve(kind, seed), 0.4, 9), 0.05, Method::kOptimal);
      CHECK(r.trajectory.certificate.lower_bound_s < r.continuous_s);
      sum += r.trajectory.certificate.lower_bound_s / r.continuous_s;
      ++curves;
    }
  CHECK(sum > 0.9 * curves);
}

TEST_CASE("The decimals of a path tell its rounding") {
  CHECK(rounding_mm(std::vector<Point2>{{1.25, 3.0}, {0.125, 7.5}}) == Approx(0.0005));
  CHECK(rounding_mm(std::vector<Point2>{{1.25, 3.0}, {0.5, 7.5}}) == Approx(0.005));
  CHECK(rounding_mm(std::vector<Point2>{{10.0, 3.0}, {0.5, 7.5}}) == 0.0);
  CHECK(rounding_mm(std::vector<Point2>{{1.0 / 3.0, 3.0}, {0.5, 7.5}}) == 0.0);
}

TEST_CASE("An ellipse of 90 x 60 mm takes the same time at any spacing and rounding within 0.05 mm") {
  double least = 1e300, most = 0.0;
  for (const auto& [step, decimals] : {std::pair{0.1, 3}, {0.3, 9}, {0.1, 9}, {1.0, 9}, {1.0, 3}}) {
    const double t = plan_curve(sampled(ellipse(45.0, 30.0), step, decimals), 0.05).continuous_s;
    INFO("step " << step << ", decimals " << decimals);
    CHECK(t < 1.04 * 2.36);
    least = std::min(least, t);
    most = std::max(most, t);
  }
  CHECK(most < 1.02 * least);
}

TEST_CASE("A rose is not slower for more points, nor for a larger tolerance") {
  for (const int decimals : {3, 9}) {
    double before = 1e300;
    for (const double tolerance : {0.01, 0.02, 0.05, 0.1}) {
      const double coarse = plan_curve(sampled(rose(), 0.4, decimals), tolerance).continuous_s,
                   dense = plan_curve(sampled(rose(), 0.1, decimals), tolerance).continuous_s;
      INFO("decimals " << decimals << ", tolerance " << tolerance);
      CHECK(dense < 1.01 * coarse);
      CHECK(coarse < 1.005 * before);
      before = coarse;
    }
  }
}

TEST_CASE(
    "Chance runs of points on a circle are no arcs: a rose without tolerance takes the same at any spacing") {
  const double coarse = plan_curve(sampled(rose(), 0.4, 12), 0.0).continuous_s;
  for (const double step : {0.2, 0.1})
    CHECK(plan_curve(sampled(rose(), step, 12), 0.0).continuous_s < 1.05 * coarse);
}

TEST_CASE("Without tolerance, points rounded to a micrometre are followed within that, and fast") {
  const PlanResult exact = plan_curve(sampled(rose(), 0.3, 12), 0.0),
                   rounded = plan_curve(sampled(rose(), 0.3, 3), 0.0);
  CHECK(rounded.continuous_s < 1.15 * exact.continuous_s);
  CHECK(rounded.deviation_mm < 0.035);
}

TEST_CASE("A fit with a cusp, on which the solver finds no motion, costs that shape and not the path") {
  const std::vector<Point2> points{
      {335.04626836927093, -7.4814720177980849}, {321.21230924560899, -15.061066370658713},
      {333.31860836142232, -2.4769210301536617}, {337.0397261346306, -1.861288496330662},
      {332.0917955982556, 0.46564397162175908},  {334.2119237053235, 0.32809526050046323},
      {319.87940754772154, 1.2579537525562632},  {334.18975475906655, 1.6730661225151628},
      {333.6520475816472, -0.69159706800835075}, {347.79210988302407, 10.678301290206075},
      {355.29173408165559, 7.114847934992242},   {353.24053531159814, 10.210061698397963},
      {347.31105105355431, 7.8784978421823295},  {359.14028673643975, 10.4532866393651}};
  const auto arm = make_scara(cobra600());
  PathInput input;
  input.points = points;
  PlanOptions options;
  options.tolerance_mm = 0.005674291951681381;
  const PlanResult result = plan(input, *arm, cobra600_limits(), options);
  INFO((result.ok() ? std::string() : describe(*result.fault)));
  REQUIRE(result.ok());
  CHECK(result.deviation_mm <= options.tolerance_mm);
  for (const LimitRatio& limit : result.trajectory.certificate.limits) CHECK(limit.ratio <= 1.0);
}

TEST_CASE("The velocities of the axes are those of the positions: a cubic through both meets a finer tick") {
  PlanOptions options;
  options.axis_rates = true;
  options.tolerance_mm = 0.05;
  const std::vector<Point2> points = sampled(rose(), 0.3, 9);
  const auto arm = make_scara(cobra600());
  PathInput input;
  input.points = points;
  input.origin = {400.0, 0.0};
  for (const Method method : {Method::kCertified, Method::kThesis}) {
    INFO(name(method));
    options.method = method;
    const PlanResult r = plan(input, *arm, cobra600_limits(), options);
    REQUIRE(r.ok());
    const Trajectory& t = r.trajectory;
    const std::size_t axes = std::size_t(t.axes);
    REQUIRE(r.axis_rates.size() == t.positions.size());
    const double h = t.tick_s;
    double worst = 0.0;
    for (std::size_t n = 1; n + 2 < t.samples(); ++n)
      for (std::size_t a = 0; a < 2; ++a) {
        // the mean of both velocities, less h/12 of what they changed by in their neighbourhood, is the
        // velocity of the step between them
        const auto p = [&](std::size_t k) { return t.positions[k * axes + a]; };
        const auto v = [&](std::size_t k) { return r.axis_rates[k * axes + a]; };
        const double mean = 0.5 * (v(n) + v(n + 1)) - (v(n + 2) - v(n + 1) - v(n) + v(n - 1)) / 24.0;
        worst = std::max(worst, std::abs(p(n + 1) - p(n) - h * mean));
      }
    // rad; central differences are off by what 1320 deg/s^3 makes of a tick
    CHECK(worst < (method == Method::kCertified ? 2e-6 : 2e-5));
    for (std::size_t a = 0; a < axes; ++a) {
      CHECK(std::abs(r.axis_rates[a]) < 1e-9);
      CHECK(std::abs(r.axis_rates[r.axis_rates.size() - 1 - a]) < 1e-9);
    }
  }
}

TEST_CASE("Seeded curves at any sampling: within the tolerance, near the slow tier, no slower for more") {
  for (int kind = 0; kind < kCurveKinds; ++kind) {
    RandomStream draw(std::uint64_t(kind) + 70, Purpose::kTest);
    const ParametricCurve curve = random_curve(kind, std::uint64_t(kind) + 70);
    const double step = 0.1 * std::pow(10.0, draw.uniform(0.0, 1.0)), tolerance = draw.uniform(0.01, 0.08);
    for (const int decimals : {3, 9}) {
      INFO(kCurveKind[kind] << ", step " << step << ", decimals " << decimals << ", tolerance " << tolerance);
      const double t = plan_curve(sampled(curve, step, decimals), tolerance).continuous_s;
      CHECK(t < 1.03 * plan_curve(sampled(curve, step, decimals), tolerance, Method::kOptimal).continuous_s);
      CHECK(plan_curve(sampled(curve, step, decimals), 1.5 * tolerance).continuous_s < 1.005 * t);
      CHECK(plan_curve(sampled(curve, 0.5 * step, decimals), tolerance).continuous_s < 1.015 * t);
    }
  }
}

namespace {

/// Durations of a curve as `motion_paths 1 SEED KIND` draws it.
struct DrawnCurve {
  ParametricCurve curve;
  double step = 0.0, tolerance = 0.0;
  int decimals = 0;

  DrawnCurve(int kind, std::uint64_t seed) : curve(random_curve(kind, seed)) {
    constexpr int kDecimals[3] = {3, 4, 9};
    RandomStream draw(seed, Purpose::kTest);
    step = 0.05 * std::pow(40.0, draw.uniform(0.0, 1.0));
    decimals = kDecimals[draw.below(3)];
    tolerance = 0.005 * std::pow(20.0, draw.uniform(0.0, 1.0));
  }
  double time_s(double steps, double tolerances) const {
    return plan_curve(sampled(curve, steps * step, decimals), tolerances * tolerance).continuous_s;
  }
};

}  // namespace

TEST_CASE("Descent from two starts: these lobes are not slower in a wider tube, nor sampled more densely") {
  const DrawnCurve lobes(0, 103);
  const double t = lobes.time_s(1.0, 1.0);
  CHECK(lobes.time_s(1.0, 1.5) < 1.005 * t);
  CHECK(lobes.time_s(0.5, 1.0) < 1.01 * t);
}

TEST_CASE("A curve that leaves the tolerance in one place is no slower for it elsewhere") {
  const DrawnCurve polygon(0, 9001);  // its samples miss it by 18 tolerances
  const double t = polygon.time_s(1.0, 1.0);
  CHECK(polygon.time_s(1.0, 1.32) < 0.96 * t);
  CHECK(polygon.time_s(1.0, 1.5) < 0.93 * t);
}

TEST_CASE("The time of the fast tier hardly depends on where the cells of its last curve fall") {
  const DrawnCurve lobes(0, 9742);
  const double t = lobes.time_s(1.0, 1.0);
  for (const double wider : {1.1, 1.25, 1.5, 1.75}) {
    INFO(wider);
    CHECK(lobes.time_s(1.0, wider) < 1.005 * t);
  }
}

TEST_CASE(
    "Coarse samples that miss their curve by about the tolerance are no faster than finer ones by 1 %") {
  for (const std::uint64_t seed : {65, 161, 599}) {
    const DrawnCurve offset(4, seed);
    CHECK(offset.time_s(0.5, 1.0) < 1.01 * offset.time_s(1.0, 1.0));
  }
}

TEST_CASE("Descent ends at nearly the same time on fillets however they are sampled") {
  // best known by ten times as many rounds on finer cells: 4.15, 5.15 s
  const struct {
    std::uint64_t seed;
    double best_s;
  } drawn[] = {{40108, 4.15}, {40132, 5.15}};
  for (const auto& [seed, best_s] : drawn) {
    const DrawnCurve fillets(5, seed);
    for (const double steps : {1.0, 0.5, 0.73}) {
      INFO(seed << ", " << steps << " of its sampling");
      CHECK(fillets.time_s(steps, 1.0) < 1.025 * best_s);
    }
  }
}

TEST_CASE("Samples that miss their curve by several tolerances are a polygon, whose tube is not narrower") {
  const DrawnCurve fillets(5, 114);
  CHECK(fillets.time_s(0.5, 1.0) < 1.01 * fillets.time_s(1.0, 1.0));
}

/// Strokes of letters, as an engraver's file has them: points a few micrometres apart, beside their lines by
/// chance, and corners.
std::vector<Point2> letters() {
  std::vector<Point2> points;
  RandomStream draw(7, Purpose::kTest);
  const auto add = [&](double x, double y) {
    const auto moved = [&](double v) { return std::round(1e3 * (v + draw.uniform(-1e-3, 1e-3))) / 1e3; };
    points.push_back({moved(x), moved(y)});
  };
  const auto line = [&](Point2 a, Point2 b, int count) {
    for (int i = 0; i < count; ++i)
      add(a.x_mm + (b.x_mm - a.x_mm) * i / count, a.y_mm + (b.y_mm - a.y_mm) * i / count);
  };
  const auto arc = [&](Point2 centre, double from, double to, int count) {
    for (int i = 0; i < count; ++i) {
      const double at = from + (to - from) * i / count;
      add(centre.x_mm + 2.0 * std::cos(at), centre.y_mm + 2.0 * std::sin(at));
    }
  };
  arc({4.0, 8.0}, 0.3, 4.71, 300);
  arc({4.0, 4.0}, 1.57, -2.8, 300);
  line({2.1, 3.3}, {10.0, 2.0}, 240);
  line({10.0, 2.0}, {10.0, 10.0}, 300);
  arc({11.5, 8.0}, 2.2, -1.57, 300);
  line({11.5, 6.0}, {14.0, 2.0}, 260);
  line({14.0, 2.0}, {20.0, 2.0}, 300);
  return points;
}

TEST_CASE("Letters are not slower within a larger tolerance whose widest fit leaves it") {
  const std::vector<Point2> points = letters();
  CHECK(plan_curve(points, 0.06).continuous_s <= 1.005 * plan_curve(points, 0.02).continuous_s);
}

TEST_CASE("The time within a tolerance hardly depends on where samples fall, nor on runs of them on a line") {
  const auto spread = [](int kind, std::uint64_t seed, int decimals, double tolerance,
                         std::initializer_list<double> steps) {
    double least = 1e300, most = 0.0;
    for (const double step : steps) {
      const double t = plan_curve(sampled(random_curve(kind, seed), step, decimals), tolerance).continuous_s;
      least = std::min(least, t);
      most = std::max(most, t);
    }
    return most / least;
  };
  constexpr int kOffsets = 4, kFillets = 5;
  CHECK(spread(kOffsets, 5058, 4, 0.08, {0.1, 0.13, 0.164, 0.2, 0.25, 0.328}) < 1.01);
  CHECK(spread(kOffsets, 5022, 9, 0.05, {0.1, 0.14, 0.2}) < 1.01);
  CHECK(spread(kFillets, 5047, 4, 0.03, {0.06, 0.09, 0.12}) < 1.01);
}

}  // namespace firn::motion
