// Error of an ice part's surface about a layer's nominal height, over the cells where the layer is judged.
#pragma once

#include "core/grid/grid.h"
#include "core/slice/paths/print_paths.h"

namespace firn::replay {

/// Means of the field over the cells of `grid`; NaN where it has none.
HeightMap cell_means(const HeightMap& field, const GridSpec& grid);

/// Where a layer is judged: its footprint with all spots between beads (up to kWidestSpot_mm wide; the slicer
/// leaves none wider than 1.45 mm), less the cells at its border, which reach beyond the beads over bare
/// table. What remains begins 1 to 2 mm inside the outer edge (at cells of 1 mm), where the outermost
/// measurement path runs [5.2.1].
Mask judged_cells(const slice::LayerPaths& layer, const GridSpec& grid);
inline constexpr double kWidestSpot_mm = 2.0;

/// Of the true surface about the nominal height, over the judged cells of `layer`, on cells of `pitch_mm`.
ErrorStats ice_error(const HeightMap& field, const slice::LayerPaths& layer, double pitch_mm);

}  // namespace firn::replay
