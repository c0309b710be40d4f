// jcon() computes JCON [Barnett 2012, 4.1.4, 4.2.5, Fig. 4-6]: it spreads sudden losses of acceleration
// ("speed-decrease" jerk) over an interval with a cubic velocity polynomial. Errata: the sum runs over k = l
// .. r-1; each side halts where the acceleration changes its sign; the test bounds the mean jerk only; (4.12)
// does not conserve arc length, so the polynomial gives speeds, and durations follow from the distances.
#pragma once

#include <cstddef>
#include <vector>

#include "core/motion/thesis/acon.h"

namespace firn::motion::thesis {

struct Interval {
  std::size_t left = 0;
  std::size_t right = 0;
};

/// Fig. 4-6: grows [left, right] until |a_r - a_l| / (sum of dt) < jerk or both sides have halted, within the
/// section.
Interval grow(Interval seed, const std::vector<double>& acceleration, const std::vector<double>& dt_s,
              double jerk, Interval section);

/// (4.12): v(tau) = D tau^3 + C tau^2 + B tau + A with v, dv/dt given at both ends of an interval of dt
/// seconds.
struct CubicSpeed {
  double a = 0.0, b = 0.0, c = 0.0, d = 0.0;
  double at(double tau) const { return ((d * tau + c) * tau + b) * tau + a; }
};
CubicSpeed cubic_speed(double v0, double v1, double a0, double a1, double dt_s);

/// JCON for the total position (by its tangential jerk), then for each joint. Only raises durations.
void jcon(Profile& profile, const MotionLimits& limits, const Margins& margins);

}  // namespace firn::motion::thesis
