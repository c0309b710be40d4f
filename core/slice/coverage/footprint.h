// Computes the cells of a grid that the extrusion lines of one layer cover, with their materials.
#pragma once

#include "core/grid/grid.h"
#include "core/slice/paths/layer_paths.h"

namespace firn::slice {

/// Returns the smallest grid of square cells, with centres at multiples of the pitch and an even number of
/// cells a side (the fast cosine transforms need that), that holds all deposited lines of the layer. Grids of
/// different layers share their cells. @throws std::invalid_argument: a layer without deposition paths, a
/// pitch not within (0, 100] mm, a grid above kMaxGridSide cells
GridSpec footprint_grid(const LayerPaths& layer, double pitch_mm);

/// Returns 0 where no line covers the centre of the cell, else 1 + the material of the nearest line.
Grid<std::uint8_t> footprint_materials(const LayerPaths& layer, const GridSpec& grid);

/// Returns 1 where footprint_materials() is not 0.
Mask footprint_mask(const Grid<std::uint8_t>& materials);

/// Returns the mask with its narrow holes closed: bare cells enclosed by the mask (under steps to four
/// neighbours) that contain no bare square of more than `widest_mm` a side. Voids between lines belong to the
/// area that a layer should cover; a bore does not, nor does a notch in the outer border.
Mask without_narrow_holes(const Mask& mask, double widest_mm);

/// Returns the deposited volume (width times length times layer height) as a share of the volume that the
/// footprint needs, holes closed as above: over 1 where lines overlap, below 1 where they leave voids. Means
/// over squares of `window_mm`; 1 outside the footprint.
HeightMap extrusion_coverage(const LayerPaths& layer, const GridSpec& grid, double window_mm,
                             double widest_hole_mm);

}  // namespace firn::slice
