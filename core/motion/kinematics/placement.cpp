#include "core/motion/kinematics/placement.h"

#include <algorithm>
#include <cmath>

namespace firn::motion {
namespace {

double constant_yaw(const PathInput& input) {
  return input.yaw_point_rad.empty() ? input.yaw_rad : input.yaw_point_rad.front();
}

Jets flange_poses(std::span<const Point2> points, std::span<const double> yaw, const PathInput& input) {
  Jets pose(kTaskAxes, points.size());
  for (int axis = 0; axis < kTaskAxes; ++axis)
    for (int order = 0; order < 4; ++order) std::fill_n(pose.of(axis, order), points.size(), 0.0);
  for (std::size_t i = 0; i < points.size(); ++i) {
    pose.of(kX, 0)[i] = points[i].x_mm;
    pose.of(kY, 0)[i] = points[i].y_mm;
    pose.of(kZ, 0)[i] = input.z_mm;
    pose.of(kYaw, 0)[i] = yaw.empty() ? constant_yaw(input) : yaw[i];
  }
  tool_to_flange(input.tool, pose, pose);
  return pose;
}

[[noreturn]] void refuse(Fault fault, Point2 tool_point, const CleanPath& path, const PathInput& input) {
  const auto squared = [&](const Point2& p) {
    const double dx = p.x_mm - tool_point.x_mm, dy = p.y_mm - tool_point.y_mm;
    return dx * dx + dy * dy;
  };
  std::size_t nearest = 0;
  for (std::size_t i = 1; i < path.points.size(); ++i)
    if (squared(path.points[i]) < squared(path.points[nearest])) nearest = i;
  fault.index = path.source[nearest];
  fault.at = {tool_point.x_mm - input.origin.x_mm, tool_point.y_mm - input.origin.y_mm};
  throw MotionError(fault);
}

}  // namespace

ArmConfiguration configuration_for(const CleanPath& path, const PathInput& input, const Arm& arm) {
  if (!path.yaw_rad.empty() && !arm.turns()) {
    Fault fault(Reason::kOption);
    fault.what = "a yaw per point, of an arm that does not turn the tool";
    fault.value = double(path.yaw_rad.size());
    throw MotionError(fault);
  }
  ArmConfiguration configuration;
  if (auto fault = arm.choose_configuration(flange_poses(path.points, path.yaw_rad, input), input.preferred,
                                            configuration))
    refuse(*fault, path.points[fault->index], path, input);
  return configuration;
}

std::vector<std::vector<double>> joints_at(std::span<const Point2> points, std::span<const double> yaw_rad,
                                           int count, const CleanPath& path, const PathInput& input,
                                           const Arm& arm, const ArmConfiguration& configuration) {
  Jets joints(count, points.size());
  if (auto fault = arm.inverse(flange_poses(points, yaw_rad, input), configuration, joints))
    refuse(*fault, points[fault->index], path, input);
  std::vector<std::vector<double>> out;
  for (int j = 0; j < count; ++j) out.emplace_back(joints.of(j, 0), joints.of(j, 0) + points.size());
  return out;
}

std::size_t whole_ticks(double duration_s, double tick_s) {
  const double ticks = std::ceil(duration_s / tick_s - 1e-9);
  if (ticks <= kMaxSamples) return std::max<std::size_t>(1, std::size_t(std::max(0.0, ticks)));
  Fault fault(Reason::kTooLong);
  fault.what = "duration in ticks";
  fault.value = ticks;
  fault.bound = kMaxSamples;
  throw MotionError(fault);
}

Trajectory trajectory_of(const std::vector<std::vector<double>>& joints, const Arm& arm, double tick_s) {
  Trajectory trajectory;
  trajectory.tick_s = tick_s;
  trajectory.axes = arm.joints();
  for (int j = 0; j < arm.joints(); ++j) trajectory.axis_units.push_back(arm.joint_unit(j));
  const std::size_t samples = joints.at(0).size();
  trajectory.positions.reserve(samples * joints.size());
  for (std::size_t n = 0; n < samples; ++n)
    for (const auto& joint : joints) trajectory.positions.push_back(joint[n]);
  return trajectory;
}

}  // namespace firn::motion
