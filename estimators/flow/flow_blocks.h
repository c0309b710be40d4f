// Computes mean rise and nominal volume per square from two maps and the pulses between them: the data of the
// flow estimate.
#pragma once

#include <array>
#include <vector>

#include "core/grid/grid.h"

namespace firn::flow {

/// Rise and nominal volume between two maps.
struct FlowInterval {
  int layer = 0;      ///< deposition layers at its end
  HeightMap rise_mm;  ///< after - before; NaN = not known
  std::array<HeightMap, 2>
      nominal_mm;  ///< deposition there by the calibrated flow of each valve: volume over area
};

/// In cells of the maps.
struct BlockOptions {
  int side = 7;    ///< of a square over which volumes are compared
  int spread = 1;  ///< liquid spreads so far about where it falls
  int rim = 2;     ///< cells nearer than that to bare cells do not count: liquid flows over a rim
};

/// Means over the cells of one square that count.
struct FlowBlock {
  double rise_mm = 0.0;
  double nominal_mm[2] = {};
  double share = 0.0;  ///< of the square's cells that count
};

/// Cells count whose rise is known and that lie inside the area covered by beads; squares with less than a
/// seventh of such cells are left out. Maps on one grid.
std::vector<FlowBlock> flow_blocks(const FlowInterval& interval, const BlockOptions& options);

}  // namespace firn::flow
