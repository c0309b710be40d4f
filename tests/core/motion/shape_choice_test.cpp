// The choice of the fastest of several curves, which plans no more of the others than may be faster.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/motion/certified/certified.h"
#include "core/motion/certified/shape_choice.h"
#include "core/motion/planner.h"
#include "core/path/rounding.h"
#include "tests/core/motion/random_paths.h"
#include "tests/core/motion/sampled_curves.h"

namespace firn::motion {
namespace {

/// One segment of a path, planned along the curve with ramps.
struct OneSegment {
  explicit OneSegment(const std::vector<Point2>& points) : path(clean({.points = points})) {}

  StopSegment planned(double max_s) {
    StopSegment out;
    ShapeChoice(path, task, work).plan(0, path.points.size() - 1, out, max_s);
    return out;
  }

  std::unique_ptr<Arm> arm = make_scara(cobra600());
  MotionLimits limits = cobra600_limits();
  PlanOptions options;
  CleanPath path;
  CertifiedTask task{*arm,
                     limits,
                     options,
                     {.configuration = {.elbow = 1}},
                     limited_joints(limits, arm->joints()),
                     row_groups(limits, limited_joints(limits, arm->joints()), false)};
  SegmentWork work;
};

std::vector<Point2> shifted(std::vector<Point2> points, double x_mm) {
  for (Point2& p : points) p.x_mm += x_mm;
  return points;
}

/// A path of each kind of curve, sampled to three decimals.
std::vector<std::vector<Point2>> sampled_paths() {
  std::vector<std::vector<Point2>> paths;
  for (int kind = 0; kind < kCurveKinds; ++kind)
    for (const double step_mm : {0.2, 1.0})
      paths.push_back(shifted(sampled(random_curve(kind, 21), step_mm, 3), 400.0));
  return paths;
}

PlanResult planned_by(const std::vector<Point2>& points, PointRule rule) {
  static const auto arm = make_scara(cobra600());
  PathInput input;
  input.points = points;
  PlanOptions options;
  options.point_noise_mm = rounding_mm(points);
  options.point_rule = rule;
  return plan(input, *arm, cobra600_limits(), options);
}

/// The faster of a held and a ramped plan that are both made to their end.
const PlanResult& faster_of(const PlanResult& held, const PlanResult& ramped) {
  if (!held.ok() || !ramped.ok()) return held.ok() ? held : ramped;
  return held.trajectory.certificate.duration_s <= ramped.trajectory.certificate.duration_s ? held : ramped;
}

}  // namespace

TEST_CASE("The faster of two curves is the one that both plans, made to their end, show") {
  std::vector<std::vector<Point2>> paths = sampled_paths();
  RandomPathMaker maker(77);
  for (int k = 0; k < 60; ++k) paths.push_back(maker.next().points);
  for (std::size_t k = 0; k < paths.size(); ++k) {
    INFO("path " << k);
    const PlanResult held = planned_by(paths[k], PointRule::kHeld),
                     ramped = planned_by(paths[k], PointRule::kRamped),
                     found = planned_by(paths[k], PointRule::kFaster);
    const PlanResult& expected = faster_of(held, ramped);
    REQUIRE(found.ok() == expected.ok());
    CHECK(found.trajectory.positions == expected.trajectory.positions);
  }
}

TEST_CASE("No motion is sought along a curve whose lower bound is above what is asked for") {
  constexpr double kCoarser = 0.99;  // the bound is first that of the curve's cells before they are divided
  for (const std::vector<Point2>& points : sampled_paths()) {
    OneSegment segment(points);
    const double bound_s = segment.planned(kNoMaxDuration_s).bound_s;
    const std::uint64_t steps = segment.work.speed.cell_steps();
    CHECK(std::isinf(segment.planned(kCoarser * bound_s).duration_s()));
    CHECK(segment.work.speed.cell_steps() == steps);
  }
}

TEST_CASE("A motion that is as fast as asked for is the same as one for which nothing is asked") {
  for (const std::vector<Point2>& points : sampled_paths()) {
    OneSegment segment(points);
    const StopSegment free = segment.planned(kNoMaxDuration_s),
                      asked = segment.planned(1.001 * free.duration_s());
    CHECK(asked.motion.t == free.motion.t);
    CHECK(asked.bound_s == free.bound_s);
  }
}

}  // namespace firn::motion
