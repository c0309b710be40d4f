// Measures of polylines: length, and the nearest point of a segment. By + - * / sqrt alone: same bytes on
// every machine.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>

#include "core/path/path.h"

namespace firn {

/// Returns the length of a polyline; of a closed one with the step from the last point to the first.
inline double path_length_mm(std::span<const Point2> points, bool closed) {
  double length = 0.0;
  for (std::size_t i = 1; i < points.size(); ++i) length += distance(points[i - 1], points[i]);
  return closed && points.size() > 1 ? length + distance(points.back(), points.front()) : length;
}

/// Returns the share of the way from a to b at which the segment is nearest to p; 0 of a segment without
/// length.
inline double nearest_share(const Point2& p, const Point2& a, const Point2& b) {
  const double dx = b.x_mm - a.x_mm, dy = b.y_mm - a.y_mm, square = dx * dx + dy * dy;
  const double along = (p.x_mm - a.x_mm) * dx + (p.y_mm - a.y_mm) * dy;
  return square > 0.0 ? std::clamp(along / square, 0.0, 1.0) : 0.0;
}

/// Returns the vector from the nearest point of the segment from a to b to p.
inline Point2 offset_from(const Point2& p, const Point2& a, const Point2& b) {
  const double share = nearest_share(p, a, b);
  return {p.x_mm - a.x_mm - share * (b.x_mm - a.x_mm), p.y_mm - a.y_mm - share * (b.y_mm - a.y_mm)};
}

/// Returns the square of the distance from p to the segment from a to b.
inline double squared_distance(const Point2& p, const Point2& a, const Point2& b) {
  const Point2 off = offset_from(p, a, b);
  return off.x_mm * off.x_mm + off.y_mm * off.y_mm;
}

}  // namespace firn
