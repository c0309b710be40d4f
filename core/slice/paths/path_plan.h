// plan_layer() computes the paths of a layer in printing order from its regions.
#pragma once

#include <cstdint>
#include <vector>

#include "core/geometry/region.h"
#include "core/slice/medial/gap_fill.h"
#include "core/slice/offset/offset_rings.h"
#include "core/slice/paths/layer_paths.h"
#include "core/slice/paths/path_options.h"

namespace firn::slice {

/// Areas to be filled in one layer: by_material[0] the part, [1] its scaffold, further parts as the job
/// defines. Regions of different materials do not overlap (the caller subtracts).
struct LayerRegions {
  std::int32_t layer = 0;   ///< 1-based
  std::int32_t z = 0;       ///< units, height of the layer's top
  std::int32_t height = 0;  ///< units
  std::vector<geometry::Region> by_material;
  geometry::Rings contours = {};  ///< from which all but the scaffold was simplified; empty: unknown
  double simplified_mm = 0;       ///< maximum distance from them
  bool contours_alone = false;    ///< the regions are bounded by them alone: no other part was subtracted
};

/// Working memory that plan_layer() keeps from layer to layer; one for each calling thread.
struct PathWork {
  OffsetWork offsets;
  GapFiller fill_gaps;
  /// The last layer. One on it of the same regions, as upright walls have, has its paths.
  LayerRegions last_regions;
  PathOptions last_options;
  LayerPaths last_paths;      ///< layer 0: there is none
  std::uint64_t planned = 0;  ///< layers whose paths were computed
};

/// Returns all paths of a layer. Layers are independent: any order and any thread will do.
LayerPaths plan_layer(const LayerRegions& regions, const PathOptions& options, PathWork& work);
LayerPaths plan_layer(const LayerRegions& regions, const PathOptions& options);

}  // namespace firn::slice
