// orientation() computes exact orientation predicates on the integer grid. Coordinates within kMaxUnits (30
// bits and a sign) keep products within 63 bits.
#pragma once

#include <algorithm>
#include <cstdint>

#include "core/geometry/region.h"

namespace firn::geometry {

/// Returns twice the signed area of a triangle: positive when c lies left of the directed line from a to b.
inline std::int64_t orientation(const Point& a, const Point& b, const Point& c) {
  return (std::int64_t(b.x) - a.x) * (std::int64_t(c.y) - a.y) -
         (std::int64_t(b.y) - a.y) * (std::int64_t(c.x) - a.x);
}
inline int sign(std::int64_t v) { return (v > 0) - (v < 0); }

struct Edge {
  Point a, b;
};

inline bool boxes_meet(const Edge& e, const Edge& f) {
  return std::min(e.a.x, e.b.x) <= std::max(f.a.x, f.b.x) &&
         std::min(f.a.x, f.b.x) <= std::max(e.a.x, e.b.x) &&
         std::min(e.a.y, e.b.y) <= std::max(f.a.y, f.b.y) && std::min(f.a.y, f.b.y) <= std::max(e.a.y, e.b.y);
}

/// Returns whether two closed segments have a point in common.
inline bool touch(const Edge& e, const Edge& f) {
  if (!boxes_meet(e, f)) return false;
  const int fa = sign(orientation(e.a, e.b, f.a)), fb = sign(orientation(e.a, e.b, f.b));
  if (fa * fb > 0) return false;
  const int ea = sign(orientation(f.a, f.b, e.a)), eb = sign(orientation(f.a, f.b, e.b));
  return ea * eb <= 0;  // four zeros: collinear, and the boxes meet
}

}  // namespace firn::geometry
