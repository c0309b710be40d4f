// speed_bound() computes the minimum-time motion within the limits of speed and acceleration, without jerk
// limits: the lower bound of every certificate.
#pragma once

#include <vector>

#include "core/motion/time_optimal/motion_rows.h"

namespace firn::motion {

/// b = v^2 at the knots [mm^2/s^2]; b linear in each cell (constant path acceleration), constraints at the
/// cells' ends. Reachability in two sweeps: backward the largest b from which the end can be reached at rest,
/// forward greedily. The feasible (b, b') at a knot are convex, symmetric about 0 and contain it, so every
/// smaller b is feasible too and one interval [0, b_max] per knot is the whole controllable set.
struct SpeedBound {
  std::vector<double> limit;  ///< from the rates of all groups and the speed limits alone
  std::vector<double> b;
  double duration_s = 0.0;
};

/// @param active number of groups, from the first, whose accelerations are constraints; further groups would
/// make the bound tighter
void speed_bound(const Curve& curve, const MotionRows& rows, const RowGroups& groups, int active,
                 SpeedBound& bound);

}  // namespace firn::motion
