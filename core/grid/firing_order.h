// firing_order computes the order in which one raster pass fires its droplets, and the runs of the stage that
// it consists of. Command, driver, audit and controllers share it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/grid/grid.h"
#include "core/grid/offsets.h"

namespace firn {

/// One straight way of the stage along x, over the droplets of one row of cells at one height in it.
struct FiringRun {
  int row = 0;     ///< j
  double y = 0.0;  ///< of all its droplets inside their cells, a share of the pitch (Offset::y)
  bool towards_plus_x = true;
  std::vector<std::uint32_t> cells;  ///< in firing order
};

/// The runs of pass `pass` (0-based) of `pattern`, over the cells with more than `pass` drops, by ascending
/// y. Without a map of places each row of cells is one run, even rows towards +x, odd rows towards -x
/// (serpentine, by row number, so that the order does not depend on which rows are empty). With one, a row is
/// a run for each of its sub-rows, two where droplets are nearer than placement.apart_mm, and each run goes
/// back on the way of the run before: by ascending y the stage travels its grid once, however many sub-rows
/// there are.
/// @pre check(placement, pattern.spec) passes; no two neighbours but one are nearer than apart_mm
std::vector<FiringRun> firing_runs(const DropletPattern& pattern, int pass, const Placement& placement = {});

/// The cells of these runs, as cell indices in firing order. Droplet n of a pass is element n.
std::vector<std::uint32_t> firing_order(const DropletPattern& pattern, int pass,
                                        const Placement& placement = {});

/// True where row j is traversed towards +x by a pass without a map of places.
inline bool towards_plus_x(int j) { return j % 2 == 0; }

}  // namespace firn
