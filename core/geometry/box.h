// BoxOf holds an axis-aligned bounding box of the plane.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

#include "core/geometry/lanes.h"

namespace firn::geometry {

/// Without points the box is empty: its minimum is above its maximum.
template <class T>
struct BoxOf {
  T x0 = std::numeric_limits<T>::max(), y0 = std::numeric_limits<T>::max();
  T x1 = std::numeric_limits<T>::lowest(), y1 = std::numeric_limits<T>::lowest();

  void add(T x, T y) {
    x0 = std::min(x0, x);
    y0 = std::min(y0, y);
    x1 = std::max(x1, x);
    y1 = std::max(y1, y);
  }
  void add(const BoxOf& o) {
    x0 = std::min(x0, o.x0);
    y0 = std::min(y0, o.y0);
    x1 = std::max(x1, o.x1);
    y1 = std::max(y1, o.y1);
  }
  bool meets(const BoxOf& o) const { return (x0 <= o.x1) & (o.x0 <= x1) & (y0 <= o.y1) & (o.y0 <= y1); }
};

/// Returns the square of half width `reach` about a point, rounded outward.
inline BoxOf<std::int32_t> box_about(double x, double y, double reach) {
  return {std::int32_t(x - reach) - 1, std::int32_t(y - reach) - 1, std::int32_t(x + reach) + 1,
          std::int32_t(y + reach) + 1};
}

/// Returns a box as x0, y0, -x1, -y1, so that one comparison of four lanes decides whether two boxes meet.
inline Lanes4 packed(const BoxOf<std::int32_t>& b) { return Lanes4{b.x0, b.y0, -b.x1, -b.y1}; }
/// Returns the upper bounds x1, y1, -x0, -y0 that no lane of a packed box exceeds if it meets this one.
inline Lanes4 reach_of(Lanes4 packed) { return -__builtin_shufflevector(packed, packed, 2, 3, 0, 1); }
inline bool meets(Lanes4 packed, Lanes4 reach) { return signs(packed > reach) == 0; }

}  // namespace firn::geometry
