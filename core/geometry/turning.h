// turn_inside_out() finds and reverses contours of the wrong orientation.
#pragma once

#include <cstddef>
#include <vector>

#include "core/geometry/region.h"

namespace firn::geometry {

/// A clockwise ring is a hole only inside another ring: if the winding number of the other rings about its
/// first point is not positive, the ring is inside out and is reversed, with all rings inside it. Larger
/// rings are processed first. @return the numbers of the reversed rings; `rings` are canonical before and
/// after (unsorted)
std::vector<std::size_t> turn_inside_out(Rings& rings);

}  // namespace firn::geometry
