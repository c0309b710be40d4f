// Holds the jobs of the tests: the paper's figures (coordinates fitted, see docs/algorithms/aerosol.md) and
// random ones.
#pragma once

#include <cmath>
#include <numbers>

#include "core/motion/aerosol/paper_jobs.h"
#include "tests/core/motion/aerosol/oracle.h"

namespace firn::test {

/// Segments through the points, each from where the last one ended.
inline PrintJob through(const std::vector<Point2>& points, double speed_mm_s = 3.0) {
  PrintJob job{points.front(), points.back(), {}};
  for (std::size_t n = 0; n + 1 < points.size(); ++n)
    job.segments.push_back({points[n], points[n + 1], speed_mm_s});
  return job;
}

/// Two segments of `length` that meet at the interior angle (180 = straight on), the first one at `heading`.
inline PrintJob corner(double angle_deg, double heading_deg, double length = 5.0, double speed = 3.0) {
  const double to_rad = std::numbers::pi / 180.0, a = heading_deg * to_rad,
               b = a + std::numbers::pi - angle_deg * to_rad;
  return through(
      {{-length * std::cos(a), -length * std::sin(a)}, {0, 0}, {length * std::cos(b), length * std::sin(b)}},
      speed);
}

inline PrintJob random_job(Numbers& next, int segments, double span_mm, double speed) {
  PrintJob job{{next(-span_mm, span_mm), next(-span_mm, span_mm)},
               {next(-span_mm, span_mm), next(-span_mm, span_mm)},
               {}};
  Point2 at = job.start;
  for (int n = 0; n < segments; ++n) {
    if (next(0, 1) < 0.3) at = {next(-span_mm, span_mm), next(-span_mm, span_mm)};
    const Point2 to{next(-span_mm, span_mm), next(-span_mm, span_mm)};
    job.segments.push_back({at, to, speed});
    at = to;
  }
  return job;
}

}  // namespace firn::test
