// OutlineStats holds the volume that lies beside a part, and the errors of its outline.
#pragma once

#include <array>

#include "core/grid/grid.h"

namespace firn {

/// Values that errors inside the part do not show. NaN = cannot be told: no cell beside the part was
/// measured, or the surface does not reach the level.
struct OutlineStats {
  double overspill = kNotMeasured;      ///< volume outside the mask over the target's volume inside it
  double first_ring_mm = kNotMeasured;  ///< mean height of the cells that share a side with the part
  double size_error_x_mm =
      kNotMeasured;  ///< width along x at half the target's largest height, less the target's
  double size_error_y_mm = kNotMeasured;  ///< the same along y
  bool cut = false;  ///< the surface reaches the level at the border of its map: the part may be wider
};

/// Computes the values of a surface. Widths are those between a caliper's jaws: from the first to the last
/// crossing of the level over all rows, interpolated linearly between cells. The target counts as 0 outside
/// the mask. `height` may reach beyond the target's grid by whole cells, so that material beyond it counts
/// too. Sums run in index order, so equal input gives equal bytes.
/// @throws std::invalid_argument: a mask of another size, a height map that does not hold the target's cells
OutlineStats outline_stats(const HeightMap& height, const HeightMap& target, const Mask& mask);

/// Returns the box around the cells of a part: x, y and its greatest height [mm].
std::array<double, 3> part_size_mm(const HeightMap& target, const Mask& mask);

/// Returns the cells of a mask whose eight neighbours all belong to it; a cell at the grid's border does not.
Mask inside_of(const Mask& mask);

}  // namespace firn
