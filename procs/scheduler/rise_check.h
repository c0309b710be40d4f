// RiseCheck compares the rise of the surface in one layer with its droplets: a nozzle that is dead, blocked
// or leaking shows in the map, whatever the pulse counters say.
#pragma once

#include <string>

#include "config/experiment.h"
#include "core/grid/grid.h"
#include "core/grid/material.h"

namespace firn {

/// Returns the disturbance in one sentence, or an empty text. The expected rise of a cell is that of the
/// model: h1 of its own droplets, h2 and h3 of its neighbours' (g1, g2, g3 of ink B).
///   drops without rise: over the cells of one ink, less than process.least_rise_share of what its own
///   droplets
///     should have added there; beside ground two layers lower, where ink runs off, a tenth of that
///   rise without drops: over the cells with droplets, more than process.most_rise_share times the expected;
///   or over
///     the cells without a droplet within two cells, more than process.least_rise_share of one droplet's
///     layer height
/// Each needs ten measured cells: fewer are within the noise of the sensor.
/// @param before, after heights [mm] of the maps below and above the layer; NaN: not measured
/// @param drops of the layer, all of them fired
/// @param materials without cells: one ink
std::string check_rise(const Experiment& experiment, const HeightMap& before, const HeightMap& after,
                       const DropletPattern& drops, const MaterialMap& materials);

}  // namespace firn
