#include "core/motion/curve/deviation.h"

#include <algorithm>
#include <cmath>

#include "core/path/polyline.h"

namespace firn::motion {
namespace {

std::vector<double> lengths(std::span<const Point2> points) {
  std::vector<double> s(points.size(), 0.0);
  for (std::size_t i = 1; i < points.size(); ++i) {
    const double dx = points[i].x_mm - points[i - 1].x_mm, dy = points[i].y_mm - points[i - 1].y_mm;
    s[i] = s[i - 1] + std::sqrt(dx * dx + dy * dy);
  }
  return s;
}

}  // namespace

double deviation(std::span<const Point2> samples, std::span<const Point2> path) {
  const std::vector<double> followed = lengths(samples), length = lengths(path);
  // A sample lies no further along than the length that was cut off so far, nor further back.
  const double window = 2.0 + std::abs(length.back() - followed.back());
  double worst = 0.0;
  std::size_t from = 0;
  for (std::size_t n = 0; n < samples.size(); ++n) {
    while (from + 2 < path.size() && length[from + 1] < followed[n] - window) ++from;
    double least = 1e300;
    for (std::size_t k = from; k + 1 < path.size() && length[k] <= followed[n] + window; ++k)
      least = std::min(least, squared_distance(samples[n], path[k], path[k + 1]));
    worst = std::max(worst, least);
  }
  return std::sqrt(worst);
}

}  // namespace firn::motion
