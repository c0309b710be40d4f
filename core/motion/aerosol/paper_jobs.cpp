#include "core/motion/aerosol/paper_jobs.h"

#include <cmath>
#include <numbers>

#include "core/exact/exact_math.h"

namespace firn::motion {

namespace {
constexpr double kSpeed_mm_s = 3.0;
}

PrintJob thompson_fig7() {
  return {{0, 10},
          {0, 0},
          {{{6, 10}, {9, 3}, kSpeed_mm_s},
           {{9, 3}, {6, 0}, kSpeed_mm_s},
           {{6, 0}, {5, 7}, kSpeed_mm_s},
           {{0, 8}, {3, 5}, kSpeed_mm_s},
           {{0, 1}, {3, 1}, kSpeed_mm_s}}};
}

PrintJob thompson_fig11() {
  constexpr int kSegments = 14;
  constexpr double kLength_mm = 5.0, kFirst_deg = 125.0, kLast_deg = 5.0, kRadian = std::numbers::pi / 180.0;
  PrintJob job;
  Point2 at;
  double heading_deg = 60.0;
  for (int n = 0; n < kSegments; ++n) {
    const Point2 to{at.x_mm + kLength_mm * exact::cos(heading_deg * kRadian),
                    at.y_mm + kLength_mm * exact::sin(heading_deg * kRadian)};
    job.segments.push_back({at, to, kSpeed_mm_s});
    at = to;
    const double angle_deg = kFirst_deg + (kLast_deg - kFirst_deg) * n / (kSegments - 2);
    heading_deg += (n % 2 == 0 ? 1.0 : -1.0) * (180.0 - angle_deg);
  }
  job.end = at;
  return job;
}

}  // namespace firn::motion
