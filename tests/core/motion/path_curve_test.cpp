// Lines and arcs from points, ramps of curvature, closed-form motions, speed limits: the basis of the
// certified planner.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <numbers>

#include "core/grid/random.h"
#include "core/motion/certified/certified.h"
#include "core/motion/curve/frechet.h"
#include "core/motion/planner.h"
#include "core/motion/thesis/test_path.h"

namespace firn::motion {
namespace {

std::vector<Point2> first_part() {
  auto points = thesis::fig_4_2();
  std::vector<std::size_t> splits;
  split_points(points, std::cos(std::numbers::pi / 6), splits);
  REQUIRE(splits.size() == 3);
  points.resize(splits[1] + 1);
  return points;
}

/// A closed ring of even chords as a path file holds it: places in steps of 1e-4 mm, off the circle by more
/// than recognition allows.
std::vector<Point2> rounded_ring(RandomStream& draw) {
  constexpr double kStep = 1e-4;
  const double radius = draw.uniform(3.0, 80.0), start = draw.uniform(0.0, 2.0 * std::numbers::pi);
  const int chords = int(2.0 * std::numbers::pi * radius / draw.uniform(0.4, 1.2));
  std::vector<Point2> points;
  const auto rounded = [&](double x) { return kStep * std::round(x / kStep); };
  for (int i = 0; i < chords; ++i) {
    const double angle = start + 2.0 * std::numbers::pi * i / chords;
    points.push_back({rounded(radius * std::cos(angle)), rounded(radius * std::sin(angle))});
  }
  points.push_back(points.front());
  return points;
}

}  // namespace

TEST_CASE("Lines and arcs are recovered from their points, although no point lies on their joints") {
  std::vector<CurvePiece> pieces;
  recognise(first_part(), kSagittaMm, pieces);
  REQUIRE(pieces.size() == 7);
  const double length[] = {26.0, 31.41592653589793, 62.0, 15.707963267948966, 77.0, 7.853981633974483, 87.0};
  const double curvature[] = {0.0, 0.05, 0.0, 0.1, 0.0, 0.2, 0.0};
  for (std::size_t i = 0; i < 7; ++i) {
    CHECK(std::abs(pieces[i].length_mm - length[i]) < kRecogniseMm);
    CHECK(std::abs(pieces[i].curvature - curvature[i]) < 1e-6);
  }
}

TEST_CASE("Pieces of a rounded ring meet, whatever circles its rounding suggests") {
  RandomStream draw(31, Purpose::kTest);
  std::vector<CurvePiece> pieces;
  double widest = 0.0;
  for (int n = 0; n < 400; ++n) {
    recognise(rounded_ring(draw), kSagittaMm, pieces);
    for (std::size_t k = 0; k + 1 < pieces.size(); ++k) {
      const Point2 end = pieces[k].at(pieces[k].length_mm), start = pieces[k + 1].start;
      widest = std::max(widest, std::hypot(end.x_mm - start.x_mm, end.y_mm - start.y_mm));
    }
  }
  CHECK(widest < 5.0 * kRecogniseMm);
}

TEST_CASE("The curve of a rounded ring stays on it") {
  RandomStream draw(32, Purpose::kTest);
  double farthest = 0.0;
  for (int n = 0; n < 400; ++n) {
    const auto points = rounded_ring(draw);
    CurveWork work;
    build_curve(points, {}, work);
    farthest = std::max(farthest, frechet_bound(work.coarse, points));
  }
  CHECK(farthest < kSagittaMm + 0.02);
}

TEST_CASE("Rounded rings, long and of a few points, are planned within their tolerance") {
  RandomStream draw(33, Purpose::kTest);
  const auto arm = make_scara(cobra600());
  PlanWorkspace work;
  PlanOptions options;
  options.slack = 0.05;
  options.lower_bound = false;
  for (int n = 0; n < 12; ++n) {
    PathInput input;
    auto points = rounded_ring(draw);
    if (n % 2 == 1) points.resize(4 + draw.below(12));
    input.points = points;
    input.origin = {354, -46};
    for (const double tolerance_mm : {0.01, 0.05, 0.2}) {
      options.tolerance_mm = tolerance_mm;
      INFO("ring " << n << ", " << input.points.size() << " points, tolerance " << tolerance_mm << " mm");
      const PlanResult result = plan(input, *arm, cobra600_limits(), options, work);
      REQUIRE(result.ok());
      CHECK(result.deviation_mm <= tolerance_mm);
    }
  }
}

TEST_CASE("Knots lie on the path, also where its ramps are longer than it") {
  std::vector<Point2> arcs;
  for (int i = 0; i < 8; ++i) arcs.push_back({1.45 * std::sin(0.05 * i), 1.45 * (1.0 - std::cos(0.05 * i))});
  const Point2 joint = arcs.back();
  for (int i = 1; i < 8; ++i) {
    const double from = 0.35, to = from + 0.08 * i;
    arcs.push_back({joint.x_mm + 1.14 * (std::sin(to) - std::sin(from)),
                    joint.y_mm - 1.14 * (std::cos(to) - std::cos(from))});
  }
  CurveOptions spec;
  spec.tolerance_mm = 0.2;
  CurveWork work;
  build_curve(arcs, spec, work);
  REQUIRE(work.pieces.size() == 2);
  REQUIRE(work.joints[1].half_ramp > work.offset.back() - work.joints[1].s);
  for (std::size_t i = 0; i + 1 < work.coarse.s.size(); ++i) CHECK(work.coarse.s[i] < work.coarse.s[i + 1]);
  CHECK(frechet_bound(work.coarse, arcs) <= 0.2);
}

TEST_CASE("A curve that is further off its path than its ramps can explain is refused, with both distances") {
  PlanOptions options;
  options.tolerance_mm = 0.05;
  StopSegment segment;
  segment.deviation_mm = 0.05 + 0.2 + kSagittaMm;
  CHECK_NOTHROW(require_near(segment, options));
  segment.deviation_mm += 0.001;
  try {
    require_near(segment, options);
    FAIL("a curve off its path was let through");
  } catch (const MotionError& error) {
    CHECK(error.fault().reason == Reason::kPathDeviation);
    CHECK(error.fault().value == segment.deviation_mm);
    CHECK(error.fault().bound == 0.05 + 0.2 + kSagittaMm);
  }
}

TEST_CASE("A jump of curvature is ramped over w, and an arc moves inward by w^2 / 24 R [errata, chapter 4]") {
  CurveWork work;
  CurveOptions spec;
  build_curve(first_part(), spec, work);
  const Curve& curve = work.coarse;
  for (std::size_t i = 0; i + 1 < curve.s.size(); ++i) {
    const double kappa = std::hypot(curve.xx[i], curve.yy[i]), s = curve.s[i];
    if (s > 27.0 && s < 56.0) {
      CHECK(std::abs(kappa - 0.05) < 1e-4);
      // centre (72, 20), R = 20
      CHECK(std::abs(std::hypot(curve.x[i] - 72.0, curve.y[i] - 20.0) - (20.0 - 0.16 / 480.0)) <
            kRecogniseMm);
    }
    if (s > 25.8 && s < 26.2) CHECK(std::abs(kappa - 0.05 * (s - 25.8) / 0.4) < 1e-4);
    if (s > 10.0 && s < 25.0) CHECK(kappa < 1e-6);
  }
}

TEST_CASE("The closed form starts and ends at rest, covers its length and holds its limits") {
  for (const double length : {1e-3, 0.5, 3.0, 20.0, 46.0, 400.0}) {
    TimedMotion motion;
    straight_motion(length, 125.0, 500.0, 4000.0, motion);
    for (std::size_t k = 0; k < motion.pieces(); ++k)
      for (int i = 0; i <= 10; ++i) {
        const PathState q = motion.state(k, motion.t[k] + (motion.t[k + 1] - motion.t[k]) * i / 10.0);
        CHECK(q.v <= 125.0 * (1.0 + 1e-9));
        CHECK(std::abs(q.a) <= 500.0 * (1.0 + 1e-9));
        CHECK(std::abs(q.j) <= 4000.0 * (1.0 + 1e-6));
      }
    CHECK(motion.s.back() == length);
    CHECK(motion.v.back() == 0.0);
  }
}

TEST_CASE("A low speed limit at the start of a path does not hold further on") {
  std::vector<Point2> points;
  for (int n = 0; n <= 100; ++n) points.push_back({double(n), 0.0});
  PathInput input;
  input.points = points;
  input.origin = {300.0, -50.0};
  input.speed_limit.point_mm_s.assign(points.size(), 80.0);
  for (std::size_t n = 0; n < 20; ++n) input.speed_limit.point_mm_s[n] = 20.0;
  const auto arm = make_scara(cobra600());
  const PlanResult r = plan(input, *arm, cobra600_limits());
  REQUIRE(r.ok());
  double most = 0.0;
  for (std::size_t n = 0; n + 1 < r.tool.size(); ++n) {
    const double v = (r.tool[n + 1].x_mm - r.tool[n].x_mm) / 0.016;
    if (r.tool[n + 1].x_mm < 19.0) CHECK(v <= 20.0 * (1.0 + 1e-9));
    most = std::max(most, v);
  }
  CHECK(most > 79.0);
  CHECK(r.trajectory.certificate.duration_s < 2.5);
}

TEST_CASE("Speed limits hold along the path and cost time") {
  const auto arm = make_scara(cobra600());
  const auto points = thesis::fig_4_2();
  PathInput input;
  input.points = points;
  input.origin = thesis::kWellPlaced;
  const PlanResult free = plan(input, *arm, cobra600_limits());
  input.speed_limit.path_mm_s = 50.0;
  input.speed_limit.point_mm_s.assign(points.size(), 1000.0);
  for (std::size_t i = 300; i < 400; ++i) input.speed_limit.point_mm_s[i] = 10.0;
  PlanOptions options;
  options.trace_step_s = 0.002;
  const PlanResult slow = plan(input, *arm, cobra600_limits(), options);
  REQUIRE(free.ok());
  REQUIRE(slow.ok());
  CHECK(slow.continuous_s > free.continuous_s + 100 * 0.4 / 10.0 - 0.4);
  const double from = 0.4 * 301, to = 0.4 * 398;
  for (const TraceSample& sample : slow.trace) {
    CHECK(sample.total[0] <= 50.0 * 1.001);
    if (sample.s_mm > from && sample.s_mm < to) CHECK(sample.total[0] <= 10.0 * 1.001);
  }
}

TEST_CASE("A Cartesian stage is planned by the same code, and a path planned twice has the same bytes") {
  CartesianConfig spec;
  spec.ranges = {{-500.0, 500.0}, {-500.0, 500.0}, {0.0, 100.0}};
  const auto stage = make_stage(spec);
  MotionLimits limits;
  limits.position = {125.0, 500.0, 4000.0};
  limits.joint[0] = limits.joint[1] = {100.0, 400.0, 3000.0};
  const auto points = thesis::fig_4_2();
  PathInput input;
  input.points = points;
  PlanWorkspace work;
  const PlanResult first = plan(input, *stage, limits, {}, work),
                   second = plan(input, *stage, limits, {}, work);
  REQUIRE(first.ok());
  for (const LimitRatio& limit : first.trajectory.certificate.limits) CHECK(limit.ratio <= 1.001);
  REQUIRE(first.trajectory.positions.size() == second.trajectory.positions.size());
  CHECK(std::memcmp(first.trajectory.positions.data(), second.trajectory.positions.data(),
                    first.trajectory.positions.size() * sizeof(double)) == 0);
}

TEST_CASE("A slight corner is rolled within the tolerance where that is faster than stopping") {
  const auto arm = make_scara(cobra600());
  const double angle = 0.6;
  const std::vector<Point2> points{{0, 0}, {30, 0}, {30 + 30 * std::cos(angle), 30 * std::sin(angle)}};
  PathInput input;
  input.points = points;
  input.origin = {360, 0};
  PlanOptions options;
  const PlanResult stopping = plan(input, *arm, cobra600_limits(), options);
  options.tolerance_mm = 0.1;
  const PlanResult rolling = plan(input, *arm, cobra600_limits(), options);
  REQUIRE(stopping.ok());
  REQUIRE(rolling.ok());
  CHECK(stopping.stops == 1);
  CHECK(rolling.stops == 0);
  CHECK(rolling.continuous_s < stopping.continuous_s);
  CHECK(rolling.deviation_mm <= 0.1);
}

}  // namespace firn::motion
