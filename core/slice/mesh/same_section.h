// same_section() tells that two layers cut the same upright walls. Where a wall is made of several facets,
// the borders between them leave points on its straight lines, each layer others.
#pragma once

#include "core/geometry/region.h"

namespace firn::slice {

/// Returns whether the contours of two layers, canonical and in the same order, have the same corners. Points
/// that the straight line from one corner to the next passes within a unit are none. So the contours lie
/// within two units of each other.
bool same_section(const geometry::Rings& a, const geometry::Rings& b);

}  // namespace firn::slice
