// vcon() computes VCON [Barnett 2012, 4.1.2]: the envelope of highest speed, as shortest point-to-point
// durations. Errata: (4.2), (4.5) third rows are jerk; (4.4) holds for each joint j; in (4.5) the bound is
// outside the root of the squares; both assume a locally constant dt (the q' s-double-dot part is dropped),
// so the envelope is a heuristic, not a bound.
#pragma once

#include "core/motion/thesis/profile.h"

namespace firn::motion::thesis {

/// First, second and third differences of a coordinate, the latter two brought to the n - 1 intervals by
/// linear interpolation (Delta^2 p*, Delta^3 p*). Needs n >= 4.
struct Differences {
  std::vector<double> first, second, third;
};
Differences differences(const std::vector<double>& values);

/// (4.4): dt_i >= |Dp_i| / rate, (|D2p_i| / acceleration)^(1/2), (|D3p_i| / jerk)^(1/3). Raises dt.
void impose_joint(const std::vector<double>& joint, const RateLimits& limits, std::vector<double>& dt_s);

/// (4.5) with the total differences of x and y. Raises dt.
void impose_position(const std::vector<Point2>& points, const RateLimits& limits, std::vector<double>& dt_s);

/// All constraints (six of two joints, three of position) and the speed limit; fills profile.dt_s.
void vcon(Profile& profile, const MotionLimits& limits);

}  // namespace firn::motion::thesis
