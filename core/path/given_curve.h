// GivenCurve holds an arc or a cubic Bezier curve that a file gives as such. Depends on nothing but points.
#pragma once

#include <cstdint>
#include <utility>

#include "core/path/path.h"

namespace firn {

/// The points of a path from `first` to `last` are samples of it.
struct GivenCurve {
  enum class Kind : std::uint8_t { kArc, kBezier };
  Kind kind = Kind::kArc;
  std::size_t first = 0, last = 0;  ///< both points lie on the curve; a full circle has two equal ones
  Point2 centre;                    ///< of the arc
  bool clockwise = false;
  Point2 start, control[2], end;  ///< of the Bezier curve: its four control points
  double from = 0.0, to = 1.0;    ///< its parameters at `first` and `last`, linear in the index between them

  Point2 at(double parameter) const {
    const double x = parameter, y = 1.0 - x;
    const double a = y * y * y, b = 3.0 * y * y * x, c = 3.0 * y * x * x, d = x * x * x;
    return {a * start.x_mm + b * control[0].x_mm + c * control[1].x_mm + d * end.x_mm,
            a * start.y_mm + b * control[0].y_mm + c * control[1].y_mm + d * end.y_mm};
  }
  /// Curvature vector of the Bezier curve, d2r/ds2 [1/mm]; 0 where it has a cusp.
  Point2 bend(double parameter) const {
    const double x = parameter, y = 1.0 - x;
    const auto edge = [](Point2 p, Point2 q) {
      return Point2{3.0 * (q.x_mm - p.x_mm), 3.0 * (q.y_mm - p.y_mm)};
    };
    const Point2 e[3] = {edge(start, control[0]), edge(control[0], control[1]), edge(control[1], end)};
    const auto mix = [&](double Point2::*axis) {
      return std::pair{y * y * e[0].*axis + 2.0 * x * y * e[1].*axis + x * x * e[2].*axis,
                       2.0 * (y * (e[1].*axis - e[0].*axis) + x * (e[2].*axis - e[1].*axis))};
    };
    const auto [dx, ddx] = mix(&Point2::x_mm);
    const auto [dy, ddy] = mix(&Point2::y_mm);
    const double square = dx * dx + dy * dy, cross = dx * ddy - dy * ddx;
    if (!(square > 0.0)) return {};
    return {-dy * cross / (square * square), dx * cross / (square * square)};
  }
};

}  // namespace firn
