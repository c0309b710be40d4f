// LayerDrops holds the known passes of one layer in the form that the estimators require.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/grid/grid.h"
#include "core/grid/offsets.h"
#include "estimators/droplet/surface_filter.h"

namespace firn::droplet {

/// A lab's report of one pass.
struct PassReport {
  DropletPattern commanded;  ///< 1 where this pass commanded a droplet
  int pass = 0, passes = 1;
  std::int64_t triggered_jet = -1;                ///< droplets counted by the jet, -1 = not counted
  std::int64_t unknown_from = 0, unknown_to = 0;  ///< in firing order; equal = nothing unknown
  Placement placement = {};                       ///< which decides the firing order
};

class LayerDrops {
 public:
  /// Takes in one report. The droplets before unknown_from have been fired; where the jet counted fewer than
  /// the stage commanded, each of them counts as that share of a droplet. Cells whose droplet is uncertain,
  /// and the cells around them, do not enter the fit.
  void add(const PassReport& report);
  bool complete() const { return complete_; }  ///< nothing of this layer is still to come
  std::vector<Pass> passes() const { return passes_; }
  /// Use of the map's cells: those off the part are bare substrate and walls, which do not enter the fit.
  /// @param quality 0 where the cell was measured (height_map_t.quality)
  std::vector<Use> use_of(const HeightMap& height, std::span<const std::int8_t> quality,
                          const Mask& mask) const;

 private:
  std::vector<Pass> passes_;
  std::vector<std::uint8_t> doubt_;  ///< empty: none
  bool complete_ = false;
};

}  // namespace firn::droplet
