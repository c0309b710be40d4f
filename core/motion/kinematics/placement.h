// Computes the joints of an arm from points of a path, for all planners that work on points.
#pragma once

#include <span>
#include <vector>

#include "core/motion/kinematics/arm.h"
#include "core/motion/kinematics/path_input.h"

namespace firn::motion {

/// Returns one arm configuration for the whole path, checked at its points. Throws MotionError (kOption)
/// where the yaw varies and the arm does not turn the tool. Throws MotionError whose index and `at` are those
/// of the input's point, also where a stretch between two points leaves the workspace (see `joints_at`).
ArmConfiguration configuration_for(const CleanPath& path, const PathInput& input, const Arm& arm);

/// Joint positions [joint][point] of the first `count` joints at tool points in the base frame. Throws
/// MotionError naming the nearest input point. @param yaw_rad one per point; empty where it is constant
std::vector<std::vector<double>> joints_at(std::span<const Point2> points, std::span<const double> yaw_rad,
                                           int count, const CleanPath& path, const PathInput& input,
                                           const Arm& arm, const ArmConfiguration& configuration);

/// Points of one piece, and samples of one trajectory, that a planner makes at most: 44 hours at 16 ms.
inline constexpr double kMaxSamples = 1e7;

/// Ticks that hold `duration_s`, at least one. Throws MotionError (kTooLong) above kMaxSamples or if it is
/// not finite.
std::size_t whole_ticks(double duration_s, double tick_s);

/// A trajectory from joint positions [joint][sample] of all joints, with the arm's units.
Trajectory trajectory_of(const std::vector<std::vector<double>>& joints, const Arm& arm, double tick_s);

}  // namespace firn::motion
