// PathInput holds the input of every planner: the points of one path, its place, its tool and its speed
// limit.
#pragma once

#include <span>
#include <vector>

#include "core/motion/kinematics/limits.h"
#include "core/motion/kinematics/tool.h"
#include "core/path/given_curve.h"
#include "core/path/path.h"

namespace firn::motion {

struct PathInput {
  std::span<const Point2> points{};  ///< in the frame of the part
  PathKind kind =
      PathKind::kBoundary;  ///< the constant-speed method drives boundaries and fill at different speeds
  bool closed = false;      ///< the first point is reached again at the end (not repeated in `points`)
  Point2 origin{};          ///< of the part's frame in the arm's base frame
  double z_mm = 0.0;        ///< constant along a path
  double yaw_rad = 0.0;     ///< of the tool, constant along the path
  /// Instead: one per point, linear between them and not wrapped (a full turn is 2 pi). Empty = yaw_rad.
  std::vector<double> yaw_point_rad{};
  Tool tool{};
  PathSpeedLimit speed_limit{};
  ArmConfiguration preferred{};  ///< that of the path before
  /// Points besides the corners at which the motion comes to rest, ascending; not for the default method.
  std::vector<std::size_t> stops{};
  /// Arcs and Bezier curves among the points that are meant exactly, ascending, apart but for their ends.
  std::span<const GivenCurve> given{};
};

/// The same path ready to plan: in the arm's base frame, closed by repeating the first point, without
/// repeated points.
struct CleanPath {
  std::vector<Point2> points;  ///< tool points in the base frame; neighbours differ by more than 1e-9 mm
  std::vector<double> speed_limit_mm_s;  ///< one per segment (points - 1): the smaller value of its two ends
  std::vector<double> yaw_rad;           ///< one per point; empty where it is constant
  std::vector<std::size_t> source;       ///< index of each point in PathInput::points
  std::vector<std::size_t> stops;        ///< PathInput::stops among `points`, without the ends
  std::vector<GivenCurve> given;         ///< PathInput::given among `points`, in the base frame
};

/// Throws MotionError: kNotFinite, kTooFewPoints, kSpeedLimitSize, kSpeedLimitNotPositive, kYawSize,
/// kYawJump, kOption (a stop, a given curve).
CleanPath clean(const PathInput& input);

/// Ascending indices `splits` and the path's stops as one.
std::vector<std::size_t> with_stops(const std::vector<std::size_t>& splits, const CleanPath& path);

}  // namespace firn::motion
