// Computes PATHSPLIT [Barnett 2012, 4.1.1, 4.2.2]: subpaths between abrupt changes of direction, points at
// constant spacing.
#pragma once

#include <vector>

#include "core/motion/thesis/profile.h"

namespace firn::motion::thesis {

struct PathSplitOptions {
  double split_angle_rad = 0.5235987755982988;  ///< 30 degrees
  double spacing_mm = 0.4;
  int smoothing_points =
      0;  ///< window of the optional smoothing (cubic local regression), odd and >= 5; 0 = none
};

/// Indices of the points where the path turns by more than the split angle, with the first and the last
/// point.
std::vector<std::size_t> split_points(const std::vector<Point2>& points, double split_angle_rad);

/// Points first..last of the path at (nearly) the wanted spacing: L / round(L / spacing), at least
/// kMinIntervals intervals. Joints and durations are left empty.
inline constexpr std::size_t kMinIntervals = 8;
Profile redistribute(const CleanPath& path, std::size_t first, std::size_t last,
                     const PathSplitOptions& options);

/// Both steps. Throws MotionError (kOption).
std::vector<Profile> pathsplit(const CleanPath& path, const PathSplitOptions& options);

}  // namespace firn::motion::thesis
