// Regions of a layer -> paths in printing order.
#pragma once

#include <cstdint>
#include <vector>

#include "core/slice/medial/gap_beads.h"
#include "core/slice/paths/layer_paths.h"
#include "core/slice/offset/offset_rings.h"
#include "core/slice/paths/path_options.h"
#include "core/geometry/region.h"

namespace firn::slice {

/// Areas to be filled in one layer: by_material[0] the part, [1] its scaffold, further parts as the job says.
/// Regions of different materials do not overlap (the caller subtracts).
struct LayerRegions {
  std::int32_t layer = 0;   ///< 1-based
  std::int32_t z = 0;       ///< units, height of the layer's top
  std::int32_t height = 0;  ///< units
  std::vector<Region> by_material;
  Rings contours = {};          ///< that all but the scaffold was thinned from; empty: not known
  double thinned_mm = 0;        ///< by no more than this
  bool contours_alone = false;  ///< bound them: no other part gave way or took it
};

/// Memory that plan_layer() keeps from layer to layer; one for each thread that calls it.
struct PathWork {
  OffsetWork offsets;
  GapFinder find;
};

/// All paths of a layer. Layers do not depend on each other: call it for any, in any order, from any thread.
LayerPaths plan_layer(const LayerRegions& regions, const PathOptions& options, PathWork& work);
LayerPaths plan_layer(const LayerRegions& regions, const PathOptions& options);

}  // namespace firn::slice
