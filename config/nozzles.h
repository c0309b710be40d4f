// lowest_nozzle_mm computes the height of the lower nozzle above the table.
#pragma once

#include "config/experiment.h"

namespace firn {

/// Returns the least height of any nozzle above the table in passes and scans of droplets [mm]. The stage
/// stands at process.nozzle_gap_mm, and jet_b.offset_z_mm higher for nozzle B: with two jets the other nozzle
/// hangs lower by the offset, whatever its sign.
double lowest_nozzle_mm(const Experiment& experiment);

}  // namespace firn
