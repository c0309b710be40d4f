#include "core/motion/aerosol/axis_profile.h"

namespace firn::motion {

double AxisProfile::position(double t_s) const {
  if (t_s < tb0_s) {
    const double dt = t_s - t0_s;
    return ends.q0_mm + dt * (ends.v0_mm_s + 0.5 * a0_mm_s2 * dt);
  }
  if (t_s > tb1_s) {
    const double dt = t_s - t1_s;
    return ends.q1_mm + dt * (ends.v1_mm_s + 0.5 * a1_mm_s2 * dt);
  }
  // From the nearer end, so that neither end jumps by rounding.
  if (t_s - tb0_s <= tb1_s - t_s) {
    const double blend = tb0_s - t0_s;
    return ends.q0_mm + blend * (ends.v0_mm_s + 0.5 * a0_mm_s2 * blend) + vc_mm_s * (t_s - tb0_s);
  }
  const double blend = tb1_s - t1_s;
  return ends.q1_mm + blend * (ends.v1_mm_s + 0.5 * a1_mm_s2 * blend) + vc_mm_s * (t_s - tb1_s);
}

double AxisProfile::velocity(double t_s) const {
  if (t_s < tb0_s) return ends.v0_mm_s + a0_mm_s2 * (t_s - t0_s);
  if (t_s > tb1_s) return ends.v1_mm_s + a1_mm_s2 * (t_s - t1_s);
  return vc_mm_s;
}

}  // namespace firn::motion
