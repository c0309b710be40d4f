// arest() computes AREST [Barnett 2012, 4.1.5, 4.2.6]: acceleration from rest at the start and to rest at the
// end of a subpath, on points evenly spaced in time, since constant spacing is too coarse at low speed.
#pragma once

#include <vector>

#include "core/motion/thesis/profile.h"

namespace firn::motion::thesis {

struct RestOptions {
  double step_s = 0.008;             ///< half the output tick
  double acceleration_mm_s2 = 80.0;  ///< at the first and last instant: above the encoders' resolution
};

/// Distance and speed at 0, step, 2 step, ... from rest, with the jerk and (where the path bends, less the
/// radial part) the acceleration limit, as long as it is slower than the profile.
struct RestCurve {
  std::vector<double> s_mm;
  std::vector<double> speed_mm_s;
};
RestCurve rest_curve(const Profile& profile, const RateLimits& limits, const RestOptions& options);

/// The profile with both ends at rest: points on the rest curves, then the old points between them. Joints
/// are left empty: the points are new.
Profile arest(const Profile& profile, const RateLimits& limits, const RestOptions& options);

/// Raises durations at both ends so that each joint's own acceleration and jerk from rest stay within its
/// limits.
void arest_joints(Profile& profile, const MotionLimits& limits, const RestOptions& options);

}  // namespace firn::motion::thesis
