// Computes a path without corners, of any number of points, that stays in one place.
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include "core/path/path.h"

namespace firn::motion {

/// Samples 0.1 mm apart, rounded to 0.1 um, of a curve that winds on and on within 45 mm.
inline std::vector<Point2> winding(std::size_t count) {
  std::vector<Point2> points;
  double x = 395.0, y = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    const double s = 0.1 * double(i);
    const double heading =
        0.9 * std::sin(s / 1.7) + 0.7 * std::sin(s / 4.3 + 1.0) + 0.5 * std::sin(0.344 * s + 2.0) + s / 25.0;
    x += 0.1 * std::cos(heading);
    y += 0.1 * std::sin(heading);
    points.push_back({std::round(1e4 * x) / 1e4, std::round(1e4 * y) / 1e4});
  }
  return points;
}

}  // namespace firn::motion
