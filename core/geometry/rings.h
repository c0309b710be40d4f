// One form for a ring whatever it was made from: no repeated points, begun at its smallest, rings sorted.
#pragma once

#include <span>
#include <vector>

#include "core/geometry/region.h"

namespace firn::slice {

/// Leaves out points equal to their neighbour, turns the ring to begin at its smallest point (if that comes
/// twice: at the occurrence after which it reads smallest) and appends it; rings of fewer than three points
/// are left out. Changes `ring`.
void append_canonical(std::vector<Point>& ring, Rings& to);

/// The same rings in ascending order.
Rings sorted(Rings rings);

}  // namespace firn::slice
