// Computes exact overlays of two sets of directed rings on the grid.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/geometry/exact.h"
#include "core/geometry/region.h"

namespace firn::geometry {

/// Part of an edge between two grid points, a < b. `runs` is the net number of rings that pass from a to b,
/// per operand; `below` holds the winding numbers on its right, above() those on its left.
struct Subedge {
  Point a, b;
  std::array<std::int32_t, 2> runs{};
  std::array<std::int32_t, 2> below{};
  std::int32_t above(int operand) const { return below[std::size_t(operand)] + runs[std::size_t(operand)]; }
};

/// Snap rounding [Hobby 1999; Guibas and Marimont 1998]: grid squares that contain an end point or a crossing
/// are hot, and each edge is rerouted through the centres of all hot squares that it passes. No two subedges
/// cross. Equal ones are summed and those that cancel are left out. Sorted by (a, b).
std::vector<Subedge> snap_rounded(const Rings& first, const Rings& second);

/// Computes `below` by a sweep from left to right over subedges that do not cross.
void number_sides(std::vector<Subedge>& subedges);

/// Returns the boundary of all points for which inside(winding of first, winding of second) holds. @param
/// subedges with `below` computed
Region bounded(const std::vector<Subedge>& subedges, bool (*inside)(std::int32_t, std::int32_t));

}  // namespace firn::geometry
