// Which cells of a grid one layer's beads cover, and with what.
#pragma once

#include "core/grid/grid.h"
#include "core/slice/paths/layer_paths.h"

namespace firn::slice {

/// The smallest grid of square cells, with centres at whole multiples of the pitch, that holds every
/// deposition bead of the layer; so grids of different layers share their cells; an even number of cells a
/// side (the fast cosine transforms want that). @throws std::invalid_argument: a layer without deposition
/// paths, a pitch not within (0, 100] mm, a grid above kMaxGridSide cells
GridSpec footprint_grid(const LayerPaths& layer, double pitch_mm);

/// 0 where no bead covers the cell's centre, else 1 + the material of the nearest line.
Grid<std::uint8_t> footprint_materials(const LayerPaths& layer, const GridSpec& grid);

/// 1 where footprint_materials() is not 0.
Mask footprint_mask(const Grid<std::uint8_t>& materials);

/// The mask with its narrow holes closed: bare cells that the mask encloses (a step to one of four neighbours
/// never leads out) and among which there is no bare square of more than `widest_mm` a side. Spots between
/// beads are part of what a layer should have covered; a bore is not, nor is a notch in the outer border.
Mask without_narrow_holes(const Mask& mask, double widest_mm);

/// Volume that the beads of a layer lay (width times length times the layer's height), as a share of what its
/// footprint needs, holes closed as above: over 1 where beads overlap, below where they leave spots. Means
/// over squares of `window_mm`; 1 where there is no footprint.
HeightMap bead_coverage(const LayerPaths& layer, const GridSpec& grid, double window_mm,
                        double widest_hole_mm);

}  // namespace firn::slice
