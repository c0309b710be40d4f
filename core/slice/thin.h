// Leaves points of a ring out, once, within a tolerance.
#pragma once

#include <span>

#include "core/slice/region.h"
#include "core/slice/vec.h"

namespace firn::slice {

/// Appends a ring through some of the points of `line`, rounded to the grid, none of whose edges leaves the points it
/// skips by more than `tolerance` units. One pass: each edge grows while one direction passes within the tolerance of all
/// points skipped [Williams 1978, "An efficient algorithm for the piecewise linear approximation of planar curves"].
/// A ring that would lose its area keeps all its points; without area on the grid it is left out.
/// @return whether a ring was added
bool thin_ring(std::span<const Vec> line, double tolerance, Rings& rings);

}  // namespace firn::slice
