// The tool's yaw along a curve: linear between the points of the path, its kinks rounded, as a C2 cubic
// spline.
#include <algorithm>
#include <cmath>

#include "core/motion/curve/path_curve.h"

namespace firn::motion {

void place_yaw(std::span<const Point2> points, const CurveSpec& spec, CurveWork& work) {
  work.yaw_s.clear();
  work.yaw_half.clear();
  if (spec.yaw.empty()) return;
  auto& s = work.yaw_s;
  s.assign(points.size(), 0.0);
  for (std::size_t i = 1; i < points.size(); ++i) {
    const double dx = points[i].x_mm - points[i - 1].x_mm, dy = points[i].y_mm - points[i - 1].y_mm;
    s[i] = s[i - 1] + std::sqrt(dx * dx + dy * dy);
  }
  const double scale = work.offset.back() / s.back();
  for (double& at : s) at *= scale;
  work.yaw_half.assign(points.size(), 0.0);
  for (std::size_t i = 1; i + 1 < points.size(); ++i) {
    const double room = std::min(s[i] - s[i - 1], s[i + 1] - s[i]);
    const double before = (spec.yaw[i] - spec.yaw[i - 1]) / (s[i] - s[i - 1]),
                 after = (spec.yaw[i + 1] - spec.yaw[i]) / (s[i + 1] - s[i]);
    if (before != after && room >= 2.0 * spec.ramp_mm) work.yaw_half[i] = std::min(spec.ramp_mm, 0.5 * room);
  }
}

void sample_yaw(const CurveSpec& spec, CurveWork& work, Curve& curve) {
  curve.yaw.clear();
  curve.yaw2.clear();
  if (spec.yaw.empty()) return;
  const auto& s = work.yaw_s;
  const auto slope = [&](std::size_t i) { return (spec.yaw[i + 1] - spec.yaw[i]) / (s[i + 1] - s[i]); };
  std::size_t i = 0;
  for (const double at : curve.s) {
    while (i + 2 < s.size() && at >= s[i + 1]) ++i;
    double yaw = spec.yaw[i] + slope(i) * (at - s[i]);
    for (std::size_t k = std::max<std::size_t>(i, 1); k <= i + 1 && k + 1 < s.size(); ++k)
      if (work.yaw_half[k] > 0.0) yaw += (slope(k) - slope(k - 1)) * hat_shift(at - s[k], work.yaw_half[k]);
    curve.yaw.push_back(yaw);
  }
  spline(curve.s, curve.yaw, 0.0, 0.0, curve.yaw2, work.sweep);
}

}  // namespace firn::motion
