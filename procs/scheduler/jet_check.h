// Judges a strobe sweep against the band in which a jet must be (interlock 11), and computes the lead of the
// pulses.
#pragma once

#include "core/grid/figure.h"
#include "estimators/droplet/watch_options.h"
#include "firn/droplet_sweep_t.hpp"

namespace firn {

/// Returns what is wrong with the jet, with value, deviation and limit; empty: it may print.
Violation jet_out_of_band(const droplet_sweep_t& sweep, const droplet::WatchOptions& options);

/// Distance that the stage travels while a droplet falls: by so much pulses must come earlier [mm]. 0 where
/// the sweep does not give the velocity.
double lead_of(const droplet_sweep_t& sweep, double stage_speed_mm_s, double gap_mm);

}  // namespace firn
