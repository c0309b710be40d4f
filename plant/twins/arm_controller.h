// Holds the figures of the simulated robot controller that both of its twins share: rates, ranges, times of
// power and calibration, and the joint-interpolated move.
#pragma once

#include <array>
#include <cstdint>
#include <numbers>
#include <vector>

#include "plant/ice/arm.h"

namespace firn::plant {

inline constexpr double kRobotRad = std::numbers::pi / 180.0;
inline constexpr double kRobotTick_s = 0.016;  ///< of the trajectory generator
inline constexpr std::int64_t kPower_us = 3'000'000, kCalibrate_us = 8'000'000, kBoot_us = 2'000'000;
/// rad/s, rad/s, mm/s, rad/s [Barnett 2012, Table 2-1].
inline constexpr std::array<double, 4> kFullRate{360.0 * kRobotRad, 672.0 * kRobotRad, 1100.0,
                                                 1200.0 * kRobotRad};
inline constexpr double kStopPower_s = 0.06;  ///< the brakes without power, from full speed to rest
inline constexpr int kMotionError = -1016;    ///< V+'s number of a motion error

/// Returns the points, kRobotTick_s apart, of a move from rest to rest: all joints follow one S of the fifth
/// degree, as slow as the slowest joint needs.
/// @param share of full speed, 0 to 1
std::vector<Joints> joint_move(const Joints& from, const Joints& to, double share);

/// True within the ranges of all joints.
bool in_range(const IceArmParams& params, const Joints& q);

}  // namespace firn::plant
