#include "core/motion/curve/polyline_thinning.h"

#include <algorithm>
#include <cmath>

namespace firn::motion {
namespace {

/// The last vertex that one chord from `from` reaches.
std::size_t reach(std::span<const Point2> p, std::size_t from, double within) {
  std::size_t last = from + 1;
  double tx = 0.0, ty = 0.0, low = 0.0, high = 0.0, farthest = 0.0;
  bool directed = false;
  for (std::size_t k = from + 1; k < p.size(); ++k) {
    const double x = p[k].x_mm - p[from].x_mm, y = p[k].y_mm - p[from].y_mm, d = std::sqrt(x * x + y * y);
    if (!directed) {
      last = k;
      if (d <= 2.0 * within) continue;
      directed = true;
      tx = x / d;
      ty = y / d;
      low = -within / d;
      high = within / d;
      farthest = d;
      continue;
    }
    const double along = tx * x + ty * y, aside = tx * y - ty * x;
    if (along <= 0.5 * d || d < farthest - within) break;
    const double slope = aside / along, width = within / along;
    if (slope < low || slope > high) {
      // this vertex cannot end the chord; it may still lie inside the sleeve of a later one
      if (slope + width < low || slope - width > high) break;
    } else {
      last = k;
    }
    low = std::max(low, slope - width);
    high = std::min(high, slope + width);
    farthest = std::max(farthest, d);
  }
  return last;
}

}  // namespace

void thin_polyline(std::span<const Point2> points, double within_mm, std::vector<std::size_t>& kept) {
  kept.assign(1, 0);
  while (kept.back() + 1 < points.size()) kept.push_back(reach(points, kept.back(), within_mm));
}

}  // namespace firn::motion
