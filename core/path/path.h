// Path and Trajectory hold deposition paths and timed trajectories. Depends on nothing.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace firn {

struct Point2 {
  double x_mm = 0.0;
  double y_mm = 0.0;
  bool operator==(const Point2&) const = default;
};

/// Euclidean distance, by + - * sqrt alone: same bytes on every machine.
inline double distance(const Point2& a, const Point2& b) {
  const double dx = b.x_mm - a.x_mm, dy = b.y_mm - a.y_mm;
  return std::sqrt(dx * dx + dy * dy);
}

/// Purpose of a path. Widths and speeds follow from it.
enum class PathKind : std::uint8_t { kBoundary, kFill, kHook, kMeasurement };

/// One uninterrupted deposition or measurement path of a layer, in the part's frame.
struct Path {
  std::int32_t layer = 0;     ///< deposition layer, 1-based
  std::uint8_t material = 0;  ///< 0 = part, 1 = scaffold, further ones by job
  PathKind kind = PathKind::kFill;
  bool closed = false;    ///< the last point joins the first, which is not repeated
  double width_mm = 0.0;  ///< deposited line width; 0 for measurement
  double layer_height_mm = 0.0;
  double z_mm = 0.0;  ///< nominal height of the layer's top
  std::vector<Point2> points;
};

/// Paths in printing order.
struct PathSet {
  std::vector<Path> paths;
};

/// Largest ratio of one quantity to its limit over a trajectory, and where it occurs.
struct LimitRatio {
  std::string limit;   ///< e.g. "total acceleration", "J1 rate"
  double ratio = 0.0;  ///< <= 1 when the limit holds
  double time_s = 0.0;
};

/// Evidence that goes with a trajectory: each limit's largest ratio, the duration, and a lower bound of it.
struct Certificate {
  std::vector<LimitRatio> limits;
  double duration_s = 0.0;
  double lower_bound_s = 0.0;      ///< 0 = no bound computed
  double curvature_ramp_mm = 0.0;  ///< length w over which the checker ramps curvature
};

/// Axis positions at a fixed tick. Row-major: sample n of axis a is positions[n * axes + a].
struct Trajectory {
  std::int64_t id = 0;
  double tick_s = 0.0;
  std::int32_t axes = 0;
  std::vector<std::string> axis_units;  ///< "mm" or "rad", one per axis
  std::vector<double> positions;
  Certificate certificate;

  std::size_t samples() const { return axes ? positions.size() / std::size_t(axes) : 0; }
};

}  // namespace firn
