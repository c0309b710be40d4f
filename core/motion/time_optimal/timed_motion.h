// TimedMotion computes a motion along a curve in time: quintic Hermite pieces through (time, position, speed,
// acceleration), so that position, speed and acceleration are continuous and everything can be evaluated
// without iteration.
#pragma once

#include <span>
#include <vector>

#include "core/motion/curve/path_curve.h"
#include "core/motion/time_optimal/jerk_profile.h"

namespace firn::motion {

/// State along the path at one instant.
struct PathState {
  double s = 0.0, v = 0.0, a = 0.0, j = 0.0;
};

/// Rest to rest. Times start at 0.
struct TimedMotion {
  std::vector<double> t, s, v, a;  ///< knots

  double duration_s() const { return t.empty() ? 0.0 : t.back(); }
  std::size_t pieces() const { return t.empty() ? 0 : t.size() - 1; }
  /// State in piece k at time `at` (seconds since the start of the motion, inside that piece).
  PathState state(std::size_t piece, double at) const;
  /// Appends the states at both ends of piece k and between its `steps` equal parts.
  void states(std::size_t piece, std::size_t steps, std::vector<PathState>& out) const;
  /// d4s/dt4 in piece k at two instants, and d5s/dt5.
  struct Higher {
    double fourth_from, fourth_to, fifth;
  };
  Higher higher(std::size_t piece, double from, double to) const;
};

/// The motion of a speed profile: knots of the curve, times by Gauss's rule of four points in each cell (the
/// rest cells exactly).
void time_profile(const Curve& curve, const Profile& profile, TimedMotion& motion);

/// Minimum-time motion of length_mm from rest to rest under constant limits of speed, acceleration and jerk,
/// in closed form: up to seven pieces of constant jerk. T = L/v + v/a + a/j when all three limits are
/// reached.
void straight_motion(double length_mm, double speed_mm_s, double acceleration_mm_s2, double jerk_mm_s3,
                     TimedMotion& motion);

}  // namespace firn::motion
