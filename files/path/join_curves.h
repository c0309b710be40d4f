// join_curves() joins the curves of a drawing, which come in any order and direction, to paths.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "core/path/given_curve.h"

namespace firn {

/// Ends of one layer that are nearer to each other than this, and heights, too, are one.
inline constexpr double kJoin_mm = 1e-3;

/// Points with the arcs and Bezier curves among them; the parameters of the latter go from 0 to 1.
struct ShapedPoints {
  std::vector<Point2> points;
  std::vector<GivenCurve> given;
};

struct DrawnCurve {
  ShapedPoints shape;  ///< two points or more
  double z_mm = 0.0;
  std::string layer;
  std::size_t line = 0;  ///< of the file
};

struct JoinedCurve {
  ShapedPoints shape;
  double z_mm = 0.0;
  std::size_t line = 0;   ///< of its first curve in the file
  std::size_t parts = 1;  ///< number of curves
};

/// Joins greedily in the order of `curves`: each path grows at its end, then at its start, by the first
/// curve in the file that ends there. A closed one ends at its first point. Time: O(n log n).
void join_curves(const std::vector<DrawnCurve>& curves, const std::function<void(JoinedCurve&&)>& sink);

}  // namespace firn
