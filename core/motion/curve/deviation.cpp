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

double deviation(const Curve& curve, std::span<const Point2> points, std::vector<double>& length) {
  constexpr double window = 1.0;  // mm of path to either side in which the nearest segment is searched
  length.assign(points.size(), 0.0);
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const double dx = points[i + 1].x_mm - points[i].x_mm, dy = points[i + 1].y_mm - points[i].y_mm;
    length[i + 1] = length[i] + std::sqrt(dx * dx + dy * dy);
  }
  const double scale = length.back() / curve.s.back();
  double worst = 0.0;
  std::size_t from = 0;
  for (std::size_t i = 0; i < curve.cells(); ++i) {
    if (curve.xx[i] == 0.0 && curve.yy[i] == 0.0 && curve.xx[i + 1] == 0.0 && curve.yy[i + 1] == 0.0)
      continue;
    for (const double x : {0.0, 1.0 / 3.0, 2.0 / 3.0}) {
      const double s = curve.s[i] + x * (curve.s[i + 1] - curve.s[i]), at = s * scale;
      const Point2 p = curve.at(i, s);
      while (from + 2 < points.size() && length[from + 1] < at - window) ++from;
      double least = 1e300;
      for (std::size_t k = from; k + 1 < points.size() && length[k] <= at + window; ++k)
        least = std::min(least, squared_distance(p, points[k], points[k + 1]));
      worst = std::max(worst, least);
    }
  }
  return std::sqrt(worst);
}

}  // namespace firn::motion
