// Wanted heights that are no whole number of droplets -> droplet counts.
#pragma once

#include "core/control/options.h"
#include "core/grid/grid.h"

namespace firn::control {

/// Droplets per cell for `wanted` droplets per cell (any real number; NaN is a caller's bug), 0..max_drops,
/// zero outside the mask. kNearest: round half up. kDiffusion: Floyd-Steinberg weights 7, 3, 5, 1 over 16,
/// serpentine by row, renormalised over the mask's unvisited neighbours, so that what one cell cannot place
/// its neighbours do; the rest at a cell without such neighbours, and what exceeds the count limits by more
/// than half a droplet, is dropped. kCarry: `carry` (same grid) is added first and keeps what was not placed,
/// within +-0.5.
DropletPattern halftone(const Grid<double>& wanted, const Mask& mask, int max_drops, Rounding rounding,
                        Grid<double>& carry);

}  // namespace firn::control
