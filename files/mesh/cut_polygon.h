// cut_polygon cuts a simple polygon in space, convex or not, into triangles by ear clipping [Meisters 1975].
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/slice/mesh/facets.h"

namespace firn::mesh {

using Triangle = std::array<std::uint32_t, 3>;

/// True if a fan about the first corner covers the polygon once: it bends to one side only, seen along its
/// normal (by Newell's sum).
bool is_convex(std::span<const std::uint32_t> corners, std::span<const slice::Corner> vertices);

/// Writes corners.size() - 2 triangles, which keep every corner and the direction of the boundary: a corner
/// in the middle of a straight side belongs to the neighbour as well. A polygon that crosses itself gives
/// triangles, too, of the same boundary.
/// @param tests of a point against a triangle that may still be made; reduced by those that were made
/// @returns false: they did not suffice, and `out` is as it was
bool cut_polygon(std::span<const std::uint32_t> corners, std::span<const slice::Corner> vertices,
                 std::size_t& tests, std::span<Triangle> out);

}  // namespace firn::mesh
