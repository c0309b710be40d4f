// MotionLimits holds the kinematic limits of a trajectory (4.2), PathSpeedLimit the speed limit along a path.
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <vector>

#include "core/motion/kinematics/arm.h"

namespace firn::motion {

inline constexpr double kUnlimited = std::numeric_limits<double>::infinity();

/// Largest |rate|, |acceleration|, |jerk| of one quantity, per s, s^2, s^3. kUnlimited switches one off.
struct RateLimits {
  double rate = kUnlimited;
  double acceleration = kUnlimited;
  double jerk = kUnlimited;
};

/// [Barnett 2012, (4.2)]: total Cartesian motion (Euclidean norm, mm), orientation (yaw, rad), each joint
/// (rad or mm).
struct MotionLimits {
  RateLimits position{};
  RateLimits orientation{};
  std::array<RateLimits, kMaxJoints> joint{};
};

/// (4.10): J1 33/165/1320, J2 39/195/1560 deg, total 125 mm/s, 500 mm/s^2, 4000 mm/s^3; others unlimited.
MotionLimits cobra600_limits();

/// Number of leading joints with any finite limit, which a planner must compute.
int limited_joints(const MotionLimits& limits, int joints);

/// Throws MotionError (kLimitNotPositive, naming the limit) unless every limit is > 0 and the position's are
/// finite.
void check_limits(const MotionLimits& limits, int joints);

/// Upper bound of the path speed besides the limits: for the whole path, and per point of the input path
/// (empty = no such bound; between two points the smaller of their values holds).
struct PathSpeedLimit {
  double path_mm_s = kUnlimited;
  std::vector<double> point_mm_s;
};

/// Throws MotionError (kSpeedLimitSize, kSpeedLimitNotPositive) unless it fits a path of `points` points.
void check_speed_limit(const PathSpeedLimit& speed_limit, std::size_t points);

}  // namespace firn::motion
