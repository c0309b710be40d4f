// ScrapeCheck compares the newest map with the height of a nozzle that sweeps over it (interlock 6).
#pragma once

#include "core/grid/figure.h"
#include "core/grid/grid.h"

namespace firn {

/// Returns a violation if a cell is nearer to the nozzle than `clearance_mm`, or has no height: it counts as
/// high. Its figure is the clearance that is left [mm].
/// @param height of the surface above the table [mm]; NaN: not measured
/// @param nozzle_mm height of the nozzle above the table
Violation scrape(const HeightMap& height, double nozzle_mm, double clearance_mm);

}  // namespace firn
