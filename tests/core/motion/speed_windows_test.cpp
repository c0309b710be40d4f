// A long path is planned window by window: as fast as in one piece, proved, with memory and work in
// proportion to its length.
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "core/motion/certified/stop_choice.h"
#include "core/motion/planner.h"
#include "tests/core/motion/continuous_checker.h"
#include "tests/core/motion/winding_path.h"
#include "tests/replay/live_bytes.h"

namespace firn::motion {
namespace {

/// Duration and lower bound of the first 10,000 points, planned in one piece (kMaxWholeCells = 1e6) [s].
constexpr double kWhole_s = 42.631502, kWholeBound_s = 40.4686;

/// Plans and proves the one segment of a path without corners.
void plan_long(const std::vector<Point2>& points, const PlanOptions& options, StopWork& work) {
  static const auto arm = make_scara(cobra600());
  static const MotionLimits limits = cobra600_limits();
  PathInput input;
  input.points = points;
  const CleanPath path = clean(input);
  CertifiedTask task{*arm, limits, options, {}, limited_joints(limits, arm->joints()), {}};
  task.placement.configuration.elbow = 1;
  task.groups = row_groups(limits, task.joints, false);
  REQUIRE(plan_segments(path, task, work) == 1);
  work.segment.speed.prove(task, work.segments[0]);
}

PlanOptions rounded_samples() {
  PlanOptions options;
  options.point_noise_mm = 5e-5;
  return options;
}

}  // namespace

TEST_CASE("A path of many windows takes as long as planned in one piece, and its bound is as large") {
  StopWork work;
  plan_long(winding(10000), rounded_samples(), work);
  const StopSegment& segment = work.segments[0];
  CHECK(segment.curve.cells() > 2 * kMaxWholeCells);
  CHECK(std::abs(segment.duration_s() / kWhole_s - 1.0) < 1e-3);
  CHECK(std::abs(segment.bound_s / kWholeBound_s - 1.0) < 1e-3);
  CHECK(segment.bound_s < segment.duration_s());
}

TEST_CASE("No limit is exceeded at any instant of a path of several windows") {
  StopWork work;
  plan_long(winding(6000), rounded_samples(), work);
  const StopSegment& segment = work.segments[0];
  REQUIRE(segment.curve.cells() > kMaxWholeCells);
  for (std::size_t i = 0; i + 1 < segment.motion.t.size(); ++i)
    REQUIRE(segment.motion.t[i + 1] > segment.motion.t[i]);
  const NineRatios ratios = ContinuousChecker(segment, cobra600_limits(), 325.0, 275.0).ratios(1e-3, 0.99);
  for (const auto& row : ratios)
    for (const double ratio : row) CHECK(ratio <= 1.0 + 4e-9);
}

TEST_CASE("Held points of a path of several windows are passed within their rounding") {
  PlanOptions options;
  options.point_rule = PointRule::kHeld;
  StopWork work;
  plan_long(winding(6000), options, work);
  CHECK(work.segments[0].curve.cells() > kMaxWholeCells);
  CHECK(work.segments[0].points_off_mm <= PlanOptions::kMinHold_mm);
}

TEST_CASE("Each further point of a long path takes at most 2 kB") {
  const auto bytes = [](std::size_t count) {
    const std::vector<Point2> path = winding(count);
    PathInput input;
    input.points = path;
    PlanOptions options = rounded_samples();
    options.point_rule = PointRule::kFaster;
    const auto arm = make_scara(cobra600());
    return double(test::peak_live_bytes_of([&] { plan(input, *arm, cobra600_limits(), options); }));
  };
  CHECK(bytes(24000) - bytes(12000) < 2000.0 * 12000.0);
}

TEST_CASE("Twice the points take twice the solver's steps") {
  double before = 0.0;
  for (const std::size_t count : {6000, 12000, 24000}) {
    StopWork work;
    plan_long(winding(count), rounded_samples(), work);
    const double steps = double(work.segment.speed.cell_steps());
    INFO(count << " points: " << steps / double(count) << " steps of a cell per point");
    CHECK((before == 0.0 || std::log2(steps / before) < 1.1));
    before = steps;
  }
}

}  // namespace firn::motion
