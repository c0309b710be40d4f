// PathPart holds the part of a path between two stops, CertifiedTask the arm and the limits for all of it.
#pragma once

#include <span>
#include <vector>

#include "core/motion/curve/given_curves.h"
#include "core/motion/kinematics/path_input.h"
#include "core/motion/time_optimal/motion_rows.h"
#include "core/motion/trajectory/plan.h"

namespace firn::motion {

/// Views of a CleanPath and of a buffer of given curves.
struct PathPart {
  std::span<const Point2> points;       ///< in the base frame
  std::span<const double> speed_limit;  ///< one per chord [mm/s]
  std::span<const double> yaw_rad{};    ///< one per point, empty = constant
  std::span<const GivenCurve> given{};  ///< among the points
  std::size_t first = 0, last = 0;      ///< indices of its ends in the path
  bool points_alone = true;             ///< no part of the path is given as a curve
};

/// @param given receives the part's given curves
inline PathPart part_of(const CleanPath& path, std::size_t from, std::size_t to,
                        std::vector<GivenCurve>& given) {
  given_between(path.given, from, to, given);
  const std::span<const Point2> points(path.points);
  const std::span<const double> limits(path.speed_limit_mm_s), yaw(path.yaw_rad);
  return {points.subspan(from, to - from + 1),
          limits.subspan(from, to - from),
          yaw.empty() ? yaw : yaw.subspan(from, to - from + 1),
          given,
          from,
          to,
          path.given.empty()};
}

/// Input that all segments of a path share.
struct CertifiedTask {
  const Arm& arm;
  const MotionLimits& limits;
  const PlanOptions& options;
  Placement placement;
  int joints = 0;
  RowGroups groups;
  bool in_descent = false;  ///< the curve is being moved: finer cells, and the time's gradient
};

}  // namespace firn::motion
