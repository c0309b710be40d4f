// The plane cut up by directed rings of two operands, exactly, on the grid.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/geometry/exact.h"
#include "core/geometry/region.h"

namespace firn::slice {

/// A piece of edge between two grid points, a < b. The net number of rings that run from a to b, per operand;
/// then the winding numbers to its right ("below") and left ("above").
struct Piece {
  Point a, b;
  std::array<std::int32_t, 2> runs{};
  std::array<std::int32_t, 2> below{};
  std::int32_t above(int operand) const { return below[std::size_t(operand)] + runs[std::size_t(operand)]; }
};

/// Snap rounding [Hobby 1999; Guibas and Marimont 1998]: the grid squares that hold an end point or a
/// crossing are hot, and each edge is led through the middles of all hot squares that it passes. No two
/// pieces cross; equal ones are summed, what cancels is left out. Sorted by (a, b).
std::vector<Piece> snap_rounded(const Rings& first, const Rings& second);

/// Fills in `below`, by a sweep from left to right over pieces that do not cross.
void number_sides(std::vector<Piece>& pieces);

/// The rings round all places for which inside(winding of first, winding of second) holds. @param pieces
/// numbered.
Region bounded(const std::vector<Piece>& pieces, bool (*inside)(std::int32_t, std::int32_t));

}  // namespace firn::slice
