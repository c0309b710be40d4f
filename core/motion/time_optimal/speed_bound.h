// speed_bound() computes a motion that is faster than any within the limits: the lower bound of every
// certificate.
//
// It keeps the limits of speed and acceleration, and those parts of the tool's jerk limit in which d3s/dt3
// does not appear: across the path, and along it beside rest and below the largest speed.
#pragma once

#include <vector>

#include "core/motion/time_optimal/motion_rows.h"

namespace firn::motion {

/// b = v^2 at the knots [mm^2/s^2]; b linear in each cell (constant path acceleration), constraints at the
/// cells' ends. Reachability in two sweeps: backward the largest b from which the end can be reached at rest,
/// forward greedily. Every smaller b is feasible too, so one interval [0, b_max] per knot is the whole
/// controllable set: in w = b^(3/2) and w' all limits are convex and contain (0, 0). Across the path, with
/// curvature k, the jerk is (k w)'.
struct SpeedBound {
  std::vector<double> limit;  ///< from the rates of all groups and the speed limits alone
  std::vector<double> b;
  double duration_s = 0.0;  ///< by set_duration
};

/// The borders of a curve that is part of a longer one. Its defaults: a whole curve, at rest at both ends.
struct BoundPart {
  double first_b = 0.0, last_b = 0.0;  ///< largest b at its ends
  bool of_longer = false;              ///< its motion may be faster, its curvature larger elsewhere
  double square_curvature = 0.0;       ///< the largest of the whole [1/mm^2]
};

/// @param active number of groups, from the first, whose accelerations are constraints; further groups would
/// make the bound tighter
/// b may be above the largest feasible one by a millionth.
void speed_bound(const Curve& curve, const MotionRows& rows, const RowGroups& groups, int active,
                 SpeedBound& bound, const BoundPart& part = {});

/// Lowers b of speed_bound to the parts of the tool's jerk limit in which d3s/dt3 does not appear.
void tighten_bound(const Curve& curve, const MotionRows& rows, const RowGroups& groups, SpeedBound& bound,
                   const BoundPart& part = {});

/// Sets the duration of cells [first, last) from b.
void set_duration(const Curve& curve, const MotionRows& rows, const RowGroups& groups, std::size_t first,
                  std::size_t last, SpeedBound& bound);

}  // namespace firn::motion
