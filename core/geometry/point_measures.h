// distance, encloses and box_of measure points of the plane: how far apart two lie, whether a ring runs round
// one, the bounding box of a ring.
#pragma once

#include <span>

#include "core/geometry/box.h"
#include "core/geometry/vec.h"

namespace firn::geometry {

inline double square_distance(Point a, Point b) {
  const double x = double(a.x) - b.x, y = double(a.y) - b.y;
  return x * x + y * y;
}
inline double distance(Point a, Point b) { return std::sqrt(square_distance(a, b)); }

inline BoxOf<std::int32_t> box_of(std::span<const Point> ring) {
  BoxOf<std::int32_t> box;
  for (const Point p : ring) box.add(p.x, p.y);
  return box;
}

/// Returns whether the ring (of Points or Vecs) encloses p, by the parity of the edges right of it.
template <class Corner>
bool encloses(std::span<const Corner> ring, Corner at) {
  const auto vec = [](const Corner& c) { return Vec{double(c.x), double(c.y)}; };
  bool in = false;
  const Vec p = vec(at);
  Vec a = vec(ring.back());
  for (const Corner& corner : ring) {
    const Vec b = vec(corner);
    if ((a.y <= p.y) != (b.y <= p.y) && a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x) > p.x) in = !in;
    a = b;
  }
  return in;
}

}  // namespace firn::geometry
