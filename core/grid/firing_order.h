// Computes the order in which one raster pass fires its droplets. Command, driver, audit and controllers
// share it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/grid/grid.h"

namespace firn {

/// Cells that fire in pass `pass` (0-based) of `pattern` - those with more than `pass` drops - as cell
/// indices in firing order: rows by ascending j, even rows towards +x, odd rows towards -x (serpentine, by
/// row number, so that the order does not depend on which rows are empty). Droplet n of a pass is element n.
std::vector<std::uint32_t> firing_order(const DropletPattern& pattern, int pass);

/// True where row j is traversed towards +x.
inline bool towards_plus_x(int j) { return j % 2 == 0; }

}  // namespace firn
