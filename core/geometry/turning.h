// Contours that run the wrong way round.
#pragma once

#include <cstddef>
#include <vector>

#include "core/geometry/region.h"

namespace firn::slice {

/// A clockwise ring is a hole only where it is inside something: if the winding number of the other rings
/// round its first point is not positive there, the ring is inside out and is turned, with all that lies in
/// it. Larger rings are judged first. @returns the numbers of the rings that were turned; `rings` are
/// canonical before and after (unsorted).
std::vector<std::size_t> turn_inside_out(Rings& rings);

}  // namespace firn::slice
