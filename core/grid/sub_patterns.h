// Computes interlaced sub-patterns of a layer. They are printed one after the other with a cure between, so
// that wet droplets do not touch [Lu 2015, V-D.2].
#pragma once

#include "core/grid/grid.h"

namespace firn {

/// To which of `count` sub-patterns cell (i, j) belongs: 1: all to 0; 2: the squares of a chessboard, (i + j)
/// mod 2; 4: by (i mod 2, j mod 2), in the order (0,0), (1,1), (1,0), (0,1), so that a sub-pattern begins far
/// from the last.
/// @pre count is 1, 2 or 4
int sub_pattern_of(int i, int j, int count);

}  // namespace firn
