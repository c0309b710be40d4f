// clipper_offset() computes offsets with Clipper, where the wavefront cannot, and serves as a reference for
// it.
#pragma once

#include "core/geometry/region.h"

namespace firn::geometry {

/// Returns the offset of a region by a distance of either sign (> 0 inward), rings in no canonical order.
Rings clipper_offset(const Region& region, double inward_mm, double tolerance_mm);

}  // namespace firn::geometry
