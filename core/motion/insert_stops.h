// insert_stops() computes stops at which a path is divided, so that the data that accompany it (a valve's
// list, a robot's slot) can be cut there.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/motion/kinematics/limits.h"
#include "core/path/path.h"

namespace firn::motion {

/// A stop that was added.
struct InsertedStop {
  double along_mm = 0.0;  ///< length of the path up to it
  Point2 at;
  bool corner = false;  ///< the path turns by 5 degrees or more here; else no such point was near
};

/// The part of a planned path that must be divided: instants are those of `speed_mm_s`, step_s apart.
struct UndividedSpan {
  std::span<const double> speed_mm_s;
  double step_s = 0.016;
  std::size_t from = 0, to = 0;  ///< no stop between them
  std::size_t fits = 0;          ///< the last instant up to which a piece from `from` would reach
};

/// Divides the span into as few parts as fit with a tenth of room; each division moves to the slowest corner
/// near it, else to the nearest point, else a new point is put on the path (into `points`, and `speed_limit`
/// and `yaw_rad` where they have one entry per point). @returns the places; their indices are added to
/// `stops` (ascending), whose entries are moved for new points. @pre span.from < span.fits < span.to <
/// span.speed_mm_s.size()
std::vector<InsertedStop> insert_stops(std::vector<Point2>& points, bool closed, PathSpeedLimit& speed_limit,
                                       std::vector<double>& yaw_rad, const UndividedSpan& span,
                                       std::vector<std::size_t>& stops);

}  // namespace firn::motion
