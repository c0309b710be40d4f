// Computes the layers of a print that is measured interval by interval: measurement paths over a finished
// layer, and fills that do not lie above each other [Barnett 2012, 5.2.1].
#pragma once

#include "core/slice/paths/path_plan.h"

namespace firn::slice {

/// Concentric measurement paths over a layer.
struct IntervalMeasurement {
  double spacing_mm = 4.0;  ///< between neighbouring paths
  double offset_mm =
      0.0;  ///< from the edge of the material; 0: as its first bead, at least a quarter of the spacing
};

/// Adds closed measurement paths of one material each, the part's first: long paths over a surface that
/// reflects alike. @param deposit options of the layer's deposition paths
void add_measurement(const LayerRegions& regions, const PathOptions& deposit,
                     const IntervalMeasurement& measurement, LayerPaths& out);

/// Returns the options with one boundary path more, so that the fill lies half a bead aside. Beads that lie
/// above each other in all layers leave grooves between them that only grow, too narrow for the maps to show.
PathOptions with_shifted_fill(PathOptions options);

}  // namespace firn::slice
