// descend() computes a locally optimal plan by coordinate descent in raster order: each single-droplet change
// is tried, row by row and layer by layer, and kept when it lowers the objective, until no change does. No
// random numbers.
#pragma once

#include <cstdint>

#include "core/control/mpc/delta_cache.h"
#include "core/control/mpc/greedy.h"
#include "core/control/mpc/objective.h"

namespace firn::control::mpc {

/// Improves the plan in `objective` until no single-droplet change on a cell of the mask, in the first
/// `layers` of the horizon, lowers it by more than kMinGain_mm, or the evaluations are used up. The
/// objective never rises; the last look at every point starts from freshly computed sums.
/// @param flips of the same plan (its first `layers`, one droplet per cell at most) and surface: changes that
/// worsen it by far more than single precision errs are rejected at once, the others evaluated in double
/// precision. Same result, several times faster.
SearchResult descend(HorizonObjective& objective, int layers, std::int64_t max_evaluations,
                     DeltaCache* flips = nullptr);

}  // namespace firn::control::mpc
