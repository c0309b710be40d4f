// deviation() computes the largest distance of a sampled motion from the path that it follows.
#pragma once

#include <span>
#include <vector>

#include "core/path/path.h"

namespace firn::motion {

/// Largest distance of the samples from the polygon through `path`, which they follow from the first point to
/// the last, perhaps cutting corners.
double deviation(std::span<const Point2> samples, std::span<const Point2> path);

}  // namespace firn::motion
