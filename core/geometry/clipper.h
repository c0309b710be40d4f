// Clipper behind our types: for what our own kernels cannot answer, and to compare them with.
#pragma once

#include "core/geometry/region.h"

namespace firn::slice {

/// Offset by a distance of either sign (> 0 inward), from the region itself. No canonical order.
Rings clipper_offset(const Region& region, double inward_mm, double tolerance_mm);

/// Booleans, to compare with.
Rings clipper_unite(const Rings& a, const Rings& b);
Rings clipper_subtract(const Rings& a, const Rings& b);

}  // namespace firn::slice
