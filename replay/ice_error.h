// Computes the error of an ice part's surface about a layer's nominal height, over the cells where the layer
// is judged.
#pragma once

#include "core/grid/grid.h"
#include "core/grid/outline.h"
#include "core/slice/paths/print_paths.h"

namespace firn::replay {

/// Computes the mean of the field over each cell of `grid`; NaN where the field has no value.
HeightMap cell_means(const HeightMap& field, const GridSpec& grid);

/// Computes the mask of the cells where a layer is judged: its footprint with all spots between beads (up to
/// kWidestSpot_mm wide; the slicer leaves spots of at most 1.45 mm), less the cells at its border, which
/// reach beyond the beads over bare table. The judged cells begin 1 to 2 mm inside the outer edge (at cells
/// of 1 mm), where the outermost measurement path runs [5.2.1].
Mask judged_cells(const slice::LayerPaths& layer, const GridSpec& grid);
inline constexpr double kWidestSpot_mm = 2.0;

/// Computes the error of the true surface about the nominal height, over the judged cells of `layer`, on
/// cells of `pitch_mm`.
ErrorStats ice_error(const HeightMap& field, const slice::LayerPaths& layer, double pitch_mm);

/// The part as its lines describe it: in each cell the heights of those layers whose lines of the part
/// (material 0) cover the cell's centre.
struct NominalPart {
  HeightMap target;  ///< thickness [mm]; 0 where no line of the part runs
  Mask mask;         ///< 1 where the thickness is not 0
};
enum class NominalOf { kPart, kPartAndScaffold };
/// Computes the nominal part, or the part with its scaffold, on cells of `pitch_mm`, with `margin_mm` around
/// the lines of all layers.
/// @throws std::invalid_argument: paths without deposition lines, a grid above kMaxGridSide cells
NominalPart nominal_part(const slice::PrintPaths& paths, double pitch_mm, double margin_mm,
                         NominalOf of = NominalOf::kPart);

/// Cells and margin of outline values of parts printed along paths.
inline constexpr double kOutlineCell_mm = 0.5, kOutlineMargin_mm = 3.0;

}  // namespace firn::replay
