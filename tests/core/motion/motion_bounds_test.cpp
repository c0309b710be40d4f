// The certificate is true at every instant: proved by a checker with its own mathematics.
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <string>

#include "core/motion/certified/stop_choice.h"
#include "core/motion/planner.h"
#include "core/motion/thesis/test_path.h"
#include "tests/core/motion/continuous_checker.h"
#include "tests/core/motion/random_paths.h"

namespace firn::motion {
namespace {

const MotionLimits kLimits = cobra600_limits();
constexpr double kRounding = 4e-9;  ///< plan_certified slows down by as much

struct Proved {
  NineRatios most{};
  double bound = 0.0;  ///< the planner's
  std::size_t segments = 0;
};

/// Plans the segments of a path (in the arm's frame) as plan_certified does and checks them.
Proved prove_by_intervals(const std::vector<Point2>& points, const PlanOptions& options) {
  static const auto arm = make_scara(cobra600());
  PathInput input;
  input.points = points;
  const CleanPath path = clean(input);
  CertifiedTask task{*arm, kLimits, options, {}, limited_joints(kLimits, arm->joints()), {}};
  task.placement.configuration.elbow = 1;
  task.groups = row_groups(kLimits, task.joints, false);
  static StopWork work;
  Proved out;
  out.segments = plan_segments(path, task, work);
  for (std::size_t k = 0; k < out.segments; ++k) {
    StopSegment& segment = work.segments[k];
    work.segment.speed.prove(task, segment);
    RatioTable table = segment.ratios;
    table.scale_time(segment.factor);
    for (const auto& group : table.ratio)
      for (const double r : group) out.bound = std::max(out.bound, r);
    const NineRatios here = ContinuousChecker(segment, kLimits, 325.0, 275.0).ratios(2e-4);
    for (std::size_t q = 0; q < 3; ++q)
      for (std::size_t n = 0; n < 3; ++n) out.most[q][n] = std::max(out.most[q][n], here[q][n]);
  }
  return out;
}

double largest(const NineRatios& ratios) {
  double most = 0.0;
  for (const auto& row : ratios)
    for (const double r : row) most = std::max(most, r);
  return most;
}

std::vector<Point2> moved(std::vector<Point2> points, Point2 by) {
  for (Point2& p : points) p = {p.x_mm + by.x_mm, p.y_mm + by.y_mm};
  return points;
}

/// Zig-zags of 0.01 mm, kinks, tangent arcs, many micro-segments: the paths that broke a sampled certificate.
std::vector<Point2> foreign(int kind) {
  std::vector<Point2> points;
  if (kind == 0)
    for (int i = 0; i < 400; ++i) points.push_back({0.01 * i, i % 2 ? 0.01 : 0.0});
  if (kind == 1)
    for (int i = 0; i < 60; ++i) points.push_back({1.5 * i - 45.0, 10.0 * std::abs(std::sin(0.4 * i))});
  if (kind == 2)
    for (int i = 0; i <= 60; ++i) {
      const double a = std::numbers::pi * i / 30.0, r = i <= 30 ? 4.0 : 1.0, x = i <= 30 ? 0.0 : -3.0;
      points.push_back({x + r * std::cos(a), r * std::sin(a)});
    }
  if (kind == 3)
    for (int i = 0; i <= 10000; ++i) points.push_back({0.005 * i, 3.0 * std::sin(0.002 * i)});
  return points;
}

}  // namespace

TEST_CASE("The checker's intervals contain the derivatives of a circle driven by both joints") {
  // s = t on an arc of radius 100 about the arm's foot: J2 rests, J1 turns at 1 / 100 rad/s
  StopSegment segment;
  Curve& c = segment.curve;
  for (int i = 0; i <= 400; ++i) {
    const double a = 0.001 * i;
    c.s.push_back(400.0 * a);
    c.x.push_back(400.0 * std::cos(a));
    c.y.push_back(400.0 * std::sin(a));
    c.xx.push_back(-std::cos(a) / 400.0);
    c.yy.push_back(-std::sin(a) / 400.0);
  }
  segment.motion.t = segment.motion.s = c.s;
  segment.motion.v.assign(c.s.size(), 1.0);
  segment.motion.a.assign(c.s.size(), 0.0);
  MotionLimits unit;
  unit.position = {1.05, 1.05, 1.05};  // below 1, near which the checker halves on
  unit.joint[0] = unit.joint[1] = {1.0, 1.0, 1.0};
  const NineRatios ratio = ContinuousChecker(segment, unit, 325.0, 275.0).ratios(1e-4);
  CHECK(std::abs(ratio[0][0] - 1.0 / 1.05) < 2e-4);
  CHECK(std::abs(ratio[0][1] - 1.0 / 420.0) < 1e-5);
  CHECK(std::abs(ratio[1][0] - 1.0 / 400.0) < 1e-5);
  CHECK(ratio[2][0] < 1e-5);
}

TEST_CASE("The checker finds a limit that is exceeded between two samples") {
  StopSegment segment;
  segment.curve.s = segment.curve.x = {0.0, 1.0};
  segment.curve.y = {0.0, 0.0};
  segment.curve.x = {400.0, 401.0};
  segment.curve.xx = segment.curve.yy = {0.0, 0.0};
  segment.motion.t = segment.motion.s = {0.0, 1.0};
  segment.motion.v = segment.motion.a = {0.0, 0.0};
  MotionLimits unit;
  unit.position = {1.0, 1e3, 1e3};
  unit.joint[0] = unit.joint[1] = {1e3, 1e6, 1e6};
  // rest to rest by one quintic: 15/8 of the mean speed in the middle, 0 at both ends
  const NineRatios ratio = ContinuousChecker(segment, unit, 325.0, 275.0).ratios(1e-4);
  CHECK(ratio[0][0] >= 1.875);
  CHECK(ratio[0][0] < 1.8755);
}

TEST_CASE(
    "No limit is exceeded at any instant of the thesis's path, at both places and both speeds of work") {
  for (const Point2 origin : {thesis::kWellPlaced, thesis::kPoorlyPlaced})
    for (const Method method : {Method::kCertified, Method::kOptimal}) {
      PlanOptions options;
      options.method = method;
      const Proved proved = prove_by_intervals(moved(thesis::fig_4_2(), origin), options);
      INFO(name(method) << " at " << origin.x_mm);
      CHECK(proved.bound <= 1.0 + 1e-12);
      CHECK(largest(proved.most) <= 1.0 + kRounding);
      CHECK(largest(proved.most) > 0.98);
    }
}

TEST_CASE("No limit is exceeded at any instant on kinks, tangent arcs, zig-zags and micro-segments") {
  for (int kind = 0; kind < 4; ++kind)
    for (const double tolerance : {0.0, 0.02}) {
      PlanOptions options;
      options.tolerance_mm = tolerance;
      const Proved proved = prove_by_intervals(moved(foreign(kind), {400.0, 20.0}), options);
      INFO("kind " << kind << ", tolerance " << tolerance);
      CHECK(proved.bound <= 1.0 + 1e-12);
      CHECK(largest(proved.most) <= 1.0 + kRounding);
    }
}

TEST_CASE("No limit is exceeded at any instant of random paths, near full reach too") {
  RandomPathMaker maker(26);
  for (int k = 0; k < 24; ++k) {
    const RandomPath path = maker.next();
    PlanOptions options;
    options.tolerance_mm = k % 3 == 0 ? 0.05 : 0.0;
    INFO(path.kind << ", path " << k);
    try {
      const Proved proved = prove_by_intervals(path.points, options);
      CHECK(proved.bound <= 1.0 + 1e-12);
      CHECK(largest(proved.most) <= 1.0 + kRounding);
    } catch (const MotionError& error) {
      CHECK(error.fault().reason != Reason::kNoSolution);
    }
  }
}

}  // namespace firn::motion
