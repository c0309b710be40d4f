// MotionLimits holds the kinematic limits of a trajectory (4.2), PathSpeedLimit the speed limit along a path.
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <string_view>
#include <vector>

#include "core/motion/kinematics/arm.h"
#include "core/options/option.h"

namespace firn::motion {

inline constexpr double kUnlimited = std::numeric_limits<double>::infinity();

/// Largest |rate|, |acceleration|, |jerk| of one quantity, per s, s^2, s^3. kUnlimited switches one off.
struct RateLimits {
  double rate = kUnlimited;
  double acceleration = kUnlimited;
  double jerk = kUnlimited;
};

inline constexpr double kMaxRate = 1e6, kMaxJerk = 1e9;  ///< above, a machine file has the wrong unit

/// Bounds of the tool's total Cartesian motion, all finite.
inline constexpr OptionTable kPositionLimits{
    Option{"speed_mm_s", &RateLimits::rate, "mm/s", above(0, kMaxRate),
           "scara, stage: total Cartesian speed (4.10)"},
    Option{"acceleration_mm_s2", &RateLimits::acceleration, "mm/s^2", above(0, kMaxRate),
           "the same of acceleration"},
    Option{"jerk_mm_s3", &RateLimits::jerk, "mm/s^3", above(0, kMaxJerk), "the same of jerk"},
};

/// Bounds of one joint or of the orientation in degrees or mm; 0 = not limited.
struct AxisRates {
  double rate = 0.0, acceleration = 0.0, jerk = 0.0;
};
inline constexpr Option kAxisRate{"rate", &AxisRates::rate, "", within(0, kMaxRate),
                                  "largest rate; 0 = not limited"};
inline constexpr Option kAxisAcceleration{"acceleration", &AxisRates::acceleration, "", within(0, kMaxRate),
                                          "largest acceleration; 0 = not limited"};
inline constexpr Option kAxisJerk{"jerk", &AxisRates::jerk, "", within(0, kMaxJerk),
                                  "largest jerk; 0 = not limited"};
inline constexpr OptionTable kAxisRates{kAxisRate, kAxisAcceleration, kAxisJerk};

/// Converts to the planners' unit. @param unit rad or mm per unit of the rates
/// @throws std::invalid_argument "<where>: <rate> = <value> is outside ..."
RateLimits rate_limits(std::string_view where, const AxisRates& rates, double unit);

/// [Barnett 2012, (4.2)]: total Cartesian motion (Euclidean norm, mm), orientation (yaw, rad), each joint
/// (rad or mm).
struct MotionLimits {
  RateLimits position{};
  RateLimits orientation{};
  std::array<RateLimits, kMaxJoints> joint{};
};

/// (4.10): total motion [mm/s, mm/s^2, mm/s^3], joints 1 and 2 [deg/s, deg/s^2, deg/s^3]; others unlimited.
inline constexpr RateLimits kCobra600Position{125.0, 500.0, 4000.0};
inline constexpr AxisRates kCobra600Joint1{33.0, 165.0, 1320.0}, kCobra600Joint2{39.0, 195.0, 1560.0};
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
