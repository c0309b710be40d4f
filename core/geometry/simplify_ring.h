// simplify_ring() computes a simplified ring within a tolerance in one pass.
#pragma once

#include <span>

#include "core/geometry/region.h"
#include "core/geometry/vec.h"

namespace firn::geometry {

/// Appends a ring near `line` with fewer corners, rounded to the grid; the two lie within `tolerance` units
/// of each other. Corners lie beside the line, as far outside as the edges between them lie inside: that
/// halves the error of edges whose corners lie on the line, or needs sqrt(2) fewer of them. An edge grows
/// while some direction from its anchor passes within the tolerance of all points [after Williams 1978, "An
/// efficient algorithm for the piecewise linear approximation of planar curves"], and ends in the middle of
/// those directions. Straight parts remain in place. A ring that would lose its area keeps all its points or
/// is dropped, as `degenerate` says; a ring without area on the grid is left out.
/// @return whether a ring was added
enum class Degenerate { kKeep, kDrop };
bool simplify_ring(std::span<const Vec> line, double tolerance, Rings& rings,
                   Degenerate degenerate = Degenerate::kKeep);

}  // namespace firn::geometry
