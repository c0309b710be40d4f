// halftone() computes whole droplet counts from fractional ones by rounding or error diffusion.
#pragma once

#include "core/control/options.h"
#include "core/grid/grid.h"

namespace firn::control {

/// Droplets per cell for `wanted` droplets per cell (any real number; NaN is a caller's bug), 0..max_drops,
/// zero outside the mask. kNearest: round half up. kDiffusion: Floyd-Steinberg weights 7, 3, 5, 1 over 16,
/// serpentine by row, renormalised over the mask's unvisited neighbours, so that neighbours receive the error
/// of each cell. The error of a cell without such neighbours is dropped, and so is the part beyond the count
/// limits that exceeds half a droplet. kCarry: `carry` (same grid) is added first and keeps the error, within
/// +-0.5.
DropletPattern halftone(const Grid<double>& wanted, const Mask& mask, int max_drops, Rounding rounding,
                        Grid<double>& carry);

}  // namespace firn::control
