// Leaves points of a ring out, once, within a tolerance.
#pragma once

#include <span>

#include "core/geometry/region.h"
#include "core/geometry/vec.h"

namespace firn::slice {

/// Appends a ring near `line` with fewer corners, rounded to the grid: each lies within `tolerance` units of
/// the other. Corners stand beside the line, out by as much as the edges between them run in: half the error
/// of edges whose corners lie on it, or by sqrt(2) fewer of them. One pass: an edge grows while some
/// direction from its anchor passes within the tolerance of all places [after Williams 1978, "An efficient
/// algorithm for the piecewise linear approximation of planar curves"], and ends in the middle of those that
/// do. What is straight stays where it is. A ring that would lose its area keeps all its points, or vanishes;
/// without area on the grid it is left out.
/// @return whether a ring was added
enum class Flat { kStays, kVanishes };
bool thin_ring(std::span<const Vec> line, double tolerance, Rings& rings, Flat flat = Flat::kStays);

}  // namespace firn::slice
