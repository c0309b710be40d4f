// lowest_nozzle_mm computes the height of the lower nozzle above the table, jets_rate_hz the droplet rate of
// a pass.
#pragma once

#include "config/experiment.h"

namespace firn {

/// Returns the least height of any nozzle above the table in passes and scans of droplets [mm]. The stage
/// stands at process.nozzle_gap_mm, and jet_b.offset_z_mm higher for nozzle B: with two jets the other nozzle
/// hangs lower by the offset, whatever its sign.
double lowest_nozzle_mm(const Experiment& experiment);

/// Returns the rate that every jet of the lab follows: that of the slower one with two.
double jets_rate_hz(const Experiment& experiment);

}  // namespace firn
