// rounding_mm() computes the largest rounding of a path's coordinates from the decimals that they have.
#pragma once

#include <span>

#include "core/path/path.h"

namespace firn {

/// Half a unit of the last decimal that any coordinate has, if that is the second to the eighth: fewer
/// decimals are a drawing's own numbers, more round by nothing that matters. Otherwise 0.
double rounding_mm(std::span<const Point2> points);

}  // namespace firn
