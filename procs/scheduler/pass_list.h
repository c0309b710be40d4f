// passes_of computes the passes of a layer: the cells of one ink that are fired together, and the passes
// followed by a cure.
#pragma once

#include <cstdint>
#include <vector>

#include "core/grid/grid.h"
#include "core/grid/material.h"
#include "core/grid/offsets.h"

namespace firn {

/// One raster pass of one ink and one size of droplet.
struct Pass {
  int round = 0;  ///< fires the (round + 1)-th droplet of each of its cells
  int sub_pattern = 0;
  Material material = Material::kA;
  bool small = false;
  bool cure = true;  ///< the lamp cures after it; else the next pass joins it while it is wet
};

/// Returns the passes of a layer in the order in which they are printed: for each round, for each of
/// `sub_patterns` interlaced sub-patterns (core/grid/sub_patterns.h), ink A, then ink B, of each the
/// droplets of the first size, then the small ones, then one cure.
/// Passes without a droplet are omitted. With one sub-pattern and one ink this is one pass per round, each
/// cured.
/// @param materials without cells: all is ink A. @param placement whose table tells which places have small
/// droplets @pre sub_patterns is 1, 2 or 4; sizes agree
std::vector<Pass> passes_of(const DropletPattern& plan, const MaterialMap& materials, int sub_patterns,
                            const Placement& placement = {});

/// Returns true if a pass fires a droplet on a cell.
bool fires(const Pass& pass, const DropletPattern& plan, const MaterialMap& materials, int sub_patterns,
           int i, int j, const Placement& placement = {});

}  // namespace firn
