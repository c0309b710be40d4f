// window_mean() computes means over windows of cells.
#pragma once

#include "core/grid/grid.h"

namespace firn::control {

/// Mean over the finite cells of a window of 2 half_x + 1 by 2 half_y + 1 cells about each finite cell, cut
/// off at the grid's border; NaN where the cell itself is not finite. O(cells (half_x + half_y)): along rows,
/// then along columns.
HeightMap window_mean(const HeightMap& values, int half_x, int half_y);

}  // namespace firn::control
