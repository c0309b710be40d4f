// windings_outside() computes winding numbers of rings about points of others.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/region.h"

namespace firn::geometry {

/// As winding(Rings, Point), for one ring.
int winding(std::span<const Point> ring, Point at);

/// Returns per ring the winding number of all others about its first point.
std::vector<int> windings_outside(const Rings& rings);

/// Returns per ring the others whose bounding box holds its first point, which must be its smallest, in
/// ascending order of their left side.
std::vector<std::vector<std::uint32_t>> rings_around_first_points(const Rings& rings);

}  // namespace firn::geometry
