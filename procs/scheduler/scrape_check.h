// ScrapeCheck compares the newest map with the height of a nozzle that sweeps over it (interlock 6).
#pragma once

#include <string>

#include "core/grid/grid.h"

namespace firn {

/// Returns a sentence if a cell is nearer to the nozzle than `clearance_mm`, or has no height: it counts as
/// high. Else an empty text.
/// @param height of the surface above the table [mm]; NaN: not measured
/// @param nozzle_mm height of the nozzle above the table
std::string scrape(const HeightMap& height, double nozzle_mm, double clearance_mm);

}  // namespace firn
