// append_canonical() computes the canonical form of a ring: no repeated points, beginning at its smallest
// point.
#pragma once

#include <span>
#include <vector>

#include "core/geometry/region.h"

namespace firn::geometry {

/// Appends the canonical form of `ring`; if its smallest point occurs twice, the ring begins at the
/// occurrence from which it is lexicographically smallest. Rings of fewer than three points are left out.
/// Changes `ring`.
void append_canonical(std::vector<Point>& ring, Rings& to);

/// Returns the same rings in ascending order.
Rings sorted(Rings rings);

}  // namespace firn::geometry
