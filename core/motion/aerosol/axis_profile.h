// AxisProfile computes the motion of one axis of a stage with a trapezoidal speed profile: parabolic blend,
// constant speed, parabolic blend. [Thompson 2014, Fig. 2]
#pragma once

namespace firn::motion {

/// Boundary conditions (1) to (4). Any consistent length and speed unit; here mm and mm/s.
struct AxisEnds {
  double q0_mm = 0.0, q1_mm = 0.0;
  double v0_mm_s = 0.0, v1_mm_s = 0.0;
};

/// t0 <= tb0 <= tb1 <= t1 (18): speed v0 -> vc at a0 until tb0, vc until tb1, vc -> v1 at a1 until t1.
struct AxisProfile {
  AxisEnds ends;
  double t0_s = 0.0, tb0_s = 0.0, tb1_s = 0.0, t1_s = 0.0;
  double vc_mm_s = 0.0;
  double a0_mm_s2 = 0.0, a1_mm_s2 = 0.0;  ///< of the first and the last part, +-alpha

  double position(double t_s) const;  ///< t_s within [t0, t1]
  double velocity(double t_s) const;
};

}  // namespace firn::motion
