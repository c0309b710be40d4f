// Which rings lie round a point: boxes first, then winding numbers.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/region.h"

namespace firn::slice {

/// As winding(Rings, Point), of one ring.
int winding(std::span<const Point> ring, Point at);

/// Per ring the winding number of all others round its first point.
std::vector<int> windings_outside(const Rings& rings);

class Boxes {
 public:
  explicit Boxes(const Rings& rings);
  /// Per ring the others, in ascending order of their left side, whose box holds its first (smallest) point.
  std::vector<std::vector<std::uint32_t>> around_first_points(const Rings& rings) const;

 private:
  struct Box {
    Point low, high;
  };
  std::vector<Box> boxes_;
};

}  // namespace firn::slice
