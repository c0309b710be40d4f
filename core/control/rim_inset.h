// inset_places() computes places of droplets that move those at the outline of a part inwards.
#pragma once

#include "core/control/controller.h"

namespace firn::control {

/// Returns the place of each cell's droplets: on a cell with sides outside the mask (or at the grid's border)
/// the place of Setup::offsets nearest to `inset` pitches away from each of these sides, on all others the
/// centre; of two that lie opposite neither counts. Without cells where all are in the centre.
OffsetMap inset_places(const Setup& setup, double inset);

}  // namespace firn::control
