#include "core/motion/certified/certified.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>

#include "core/motion/kinematics/placement.h"
#include "core/motion/kinematics/require.h"

namespace firn::motion {
namespace {

Placement placement(const PathInput& input, const CleanPath& path) {
  if (!path.yaw_rad.empty()) {
    Placement place;
    place.z_mm = input.z_mm;
    place.turning = true;
    place.tool = input.tool;
    return place;
  }
  const double yaw = input.yaw_point_rad.empty() ? input.yaw_rad : input.yaw_point_rad.front();
  Jets pose(kTaskAxes, 1);
  for (int axis = 0; axis < kTaskAxes; ++axis)
    for (int order = 0; order < 4; ++order) pose.of(axis, order)[0] = 0.0;
  pose.of(kYaw, 0)[0] = yaw;
  tool_to_flange(input.tool, pose, pose);
  Placement place;
  place.z_mm = input.z_mm;
  place.yaw_rad = yaw;
  place.flange_x_mm = pose.of(kX, 0)[0];
  place.flange_y_mm = pose.of(kY, 0)[0];
  place.flange_z_mm = pose.of(kZ, 0)[0];
  return place;
}

/// The arm configuration is chosen on some of the points first: every sample's joints are checked later in
/// any case.
ArmConfiguration configuration(const CleanPath& path, const PathInput& input, const Arm& arm) {
  if (path.points.size() < 4 * kConfigurationStride) return configuration_for(path, input, arm);
  CleanPath some;
  for (std::size_t i = 0; i < path.points.size();
       i += i + kConfigurationStride < path.points.size() || i + 1 == path.points.size()
                ? kConfigurationStride
                : path.points.size() - 1 - i) {
    some.points.push_back(path.points[i]);
    some.source.push_back(path.source[i]);
    if (!path.yaw_rad.empty()) some.yaw_rad.push_back(path.yaw_rad[i]);
  }
  return configuration_for(some, input, arm);
}

void check_options(const PlanOptions& options) {
  require(options.tick_s > 0.0 && options.tick_s <= 10.0, Reason::kOption, "tick", options.tick_s, 0.0);
  require(options.tolerance_mm >= 0.0 && options.tolerance_mm <= 10.0, Reason::kOption, "tolerance",
          options.tolerance_mm, 0.0);
  require(options.curvature_ramp_mm >= 0.01 && options.curvature_ramp_mm <= 100.0, Reason::kOption,
          "curvature ramp", options.curvature_ramp_mm, 0.01);
  require(options.split_angle_rad > 0.0 && options.split_angle_rad <= 3.2, Reason::kOption, "split angle",
          options.split_angle_rad, 0.0);
}

/// A motion of more ticks than memory holds is refused before it is planned: it takes at least its length
/// over its speed limit. Differences of samples closer than kMinTick_s show the rounding of their values.
void check_ticks(const CleanPath& path, const MotionLimits& limits, const PlanOptions& options) {
  double min_s = 0.0;
  for (std::size_t i = 0; i + 1 < path.points.size(); ++i) {
    const double dx = path.points[i + 1].x_mm - path.points[i].x_mm,
                 dy = path.points[i + 1].y_mm - path.points[i].y_mm;
    min_s += std::sqrt(dx * dx + dy * dy) / std::min(path.speed_limit_mm_s[i], limits.position.rate);
  }
  whole_ticks(min_s, options.tick_s);
  if (options.trace_step_s > 0.0) whole_ticks(min_s, options.trace_step_s);
  require(options.tick_s >= kMinTick_s, Reason::kOption, "tick", options.tick_s, kMinTick_s);
}

/// The arm refused a flange position of the curve: names the input's nearest point, in the input's frame.
Fault in_input(Fault fault, const CleanPath& path, const PathInput& input, const Placement& place) {
  if (fault.reason == Reason::kNoSolution) return fault;
  if (fault.reason == Reason::kPathDeviation) {
    fault.index = path.source[fault.index];
    fault.at = input.points[fault.index];
    return fault;
  }
  fault.at.x_mm -= place.flange_x_mm;
  fault.at.y_mm -= place.flange_y_mm;
  const auto squared = [&](std::size_t i) {
    const double dx = path.points[i].x_mm - fault.at.x_mm, dy = path.points[i].y_mm - fault.at.y_mm;
    return dx * dx + dy * dy;
  };
  std::size_t nearest = 0;
  for (std::size_t i = 1; i < path.points.size(); ++i)
    if (squared(i) < squared(nearest)) nearest = i;
  fault.index = path.source[nearest];
  fault.at.x_mm -= input.origin.x_mm;
  fault.at.y_mm -= input.origin.y_mm;
  return fault;
}

/// Nothing, without a tolerance, where the path takes longer than `max_s`.
std::optional<PlanResult> plan_within(const PathInput& input, const Arm& arm, const MotionLimits& limits,
                                      const PlanOptions& options, double max_s, CertifiedWork& work) {
  check_options(options);
  check_limits(limits, arm.joints());
  const CleanPath path = clean(input);
  check_ticks(path, limits, options);
  const ArmConfiguration chosen = configuration(path, input, arm);
  CertifiedTask task{arm, limits, options, placement(input, path), limited_joints(limits, arm.joints()), {}};
  task.groups = row_groups(limits, task.joints, task.placement.turning);
  PlanResult result;
  result.configuration = task.placement.configuration = chosen;
  try {
    const std::size_t count = plan_segments(path, task, work.stops, max_s);
    if (count == 0) return std::nullopt;
    const std::span<StopSegment> segments = std::span(work.stops.segments).first(count);
    for (StopSegment& segment : segments) {
      work.stops.segment.speed.prove(task, segment);
      require_near(segment, options);
    }
    emit(input, task, segments, work.emission, result);
  } catch (const MotionError& error) {
    throw MotionError(in_input(error.fault(), path, input, task.placement));
  }
  return result;
}

}  // namespace

PlanResult plan_certified(const PathInput& input, const Arm& arm, const MotionLimits& limits,
                          const PlanOptions& options, CertifiedWork& work) {
  return *plan_within(input, arm, limits, options, kNoMaxDuration_s, work);
}

PlanResult plan_faster(const PathInput& input, const Arm& arm, const MotionLimits& limits,
                       PlanOptions options, CertifiedWork& work) {
  options.point_rule = PointRule::kHeld;
  std::optional<PlanResult> held;
  double max_s = kNoMaxDuration_s;
  try {
    held = plan_certified(input, arm, limits, options, work);
    max_s = held->trajectory.certificate.duration_s - kFewerTicks * options.tick_s;
  } catch (const MotionError&) {  // no such curve
  }
  options.point_rule = PointRule::kRamped;
  std::optional<PlanResult> ramped = plan_within(input, arm, limits, options, max_s, work);
  const auto faster = [](const PlanResult& a, const PlanResult& b) {
    return a.trajectory.certificate.duration_s < b.trajectory.certificate.duration_s;
  };
  return ramped && (!held || faster(*ramped, *held)) ? std::move(*ramped) : std::move(*held);
}

}  // namespace firn::motion
