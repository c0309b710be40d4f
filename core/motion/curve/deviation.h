// deviation() computes the largest distance of a curve from the path that it follows.
#pragma once

#include <span>
#include <vector>

#include "core/motion/curve/path_curve.h"

namespace firn::motion {

/// Largest distance of the curve (knots and two places inside every cell) from the polygon through `points`,
/// which it follows from the first to the last. @param length scratch
double deviation(const Curve& curve, std::span<const Point2> points, std::vector<double>& length);

/// Largest distance of the samples from the polygon through `path`, which they follow from the first point to
/// the last, perhaps cutting corners.
double deviation(std::span<const Point2> samples, std::span<const Point2> path);

}  // namespace firn::motion
