#include "core/motion/thesis/pathsplit.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/exact/exact_math.h"
#include "core/motion/kinematics/placement.h"
#include "core/motion/kinematics/require.h"
#include "core/motion/thesis/savitzky_golay.h"

namespace firn::motion::thesis {
namespace {

void smooth(Profile& profile, int window) {
  std::vector<double> x, y;
  for (const Point2& p : profile.points) {
    x.push_back(p.x_mm);
    y.push_back(p.y_mm);
  }
  x = local_cubic(x, window);
  y = local_cubic(y, window);
  for (std::size_t i = 1; i + 1 < profile.size(); ++i) profile.points[i] = {x[i], y[i]};  // the ends stay
  for (std::size_t i = 1; i < profile.size(); ++i)
    profile.s_mm[i] = profile.s_mm[i - 1] + distance(profile.points[i - 1], profile.points[i]);
}

}  // namespace

std::vector<std::size_t> split_points(const std::vector<Point2>& p, double split_angle_rad) {
  std::vector<std::size_t> splits{0};
  const double limit = exact::cos(split_angle_rad);
  for (std::size_t i = 1; i + 1 < p.size(); ++i) {
    const double ax = p[i].x_mm - p[i - 1].x_mm, ay = p[i].y_mm - p[i - 1].y_mm;
    const double bx = p[i + 1].x_mm - p[i].x_mm, by = p[i + 1].y_mm - p[i].y_mm;
    const double lengths = std::sqrt((ax * ax + ay * ay) * (bx * bx + by * by));
    if (ax * bx + ay * by < limit * lengths) splits.push_back(i);
  }
  splits.push_back(p.size() - 1);
  return splits;
}

Profile redistribute(const CleanPath& path, std::size_t first, std::size_t last,
                     const PathSplitOptions& options) {
  std::vector<double> s{0.0};
  for (std::size_t i = first; i < last; ++i)
    s.push_back(s.back() + distance(path.points[i], path.points[i + 1]));
  const double length = s.back();
  if (!(length / options.spacing_mm <= kMaxSamples)) {
    Fault fault(Reason::kTooLong);
    fault.what = "points at the spacing";
    fault.value = length / options.spacing_mm;
    fault.bound = kMaxSamples;
    throw MotionError(fault);
  }
  const std::size_t intervals =
      std::max(kMinIntervals, std::size_t(std::llround(length / options.spacing_mm)));
  Profile out;
  std::size_t segment = 0;
  for (std::size_t k = 0; k <= intervals; ++k) {
    const double at = k == intervals ? length : length * double(k) / double(intervals);
    const std::size_t before = segment;
    while (segment + 2 < s.size() && s[segment + 1] <= at) ++segment;
    const Point2 &a = path.points[first + segment], &b = path.points[first + segment + 1];
    const double f = k == intervals ? 1.0 : (at - s[segment]) / (s[segment + 1] - s[segment]);
    out.points.push_back({a.x_mm + f * (b.x_mm - a.x_mm), a.y_mm + f * (b.y_mm - a.y_mm)});
    if (!path.yaw_rad.empty()) {
      const double* yaw = &path.yaw_rad[first + segment];
      out.yaw_rad.push_back(yaw[0] + f * (yaw[1] - yaw[0]));
    }
    out.s_mm.push_back(at);
    if (k == 0) continue;
    double speed_limit = kUnlimited;  // every segment that the interval touches
    for (std::size_t i = before; i <= segment; ++i)
      if (s[i] < at) speed_limit = std::min(speed_limit, path.speed_limit_mm_s[first + i]);
    out.speed_limit_mm_s.push_back(speed_limit);
  }
  if (options.smoothing_points > 0) smooth(out, options.smoothing_points);
  return out;
}

std::vector<Profile> pathsplit(const CleanPath& path, const PathSplitOptions& options) {
  require(options.split_angle_rad > 0.0 && options.split_angle_rad <= std::numbers::pi, Reason::kOption,
          "split angle", options.split_angle_rad);
  require_positive(options.spacing_mm, "spacing");
  require(
      options.smoothing_points == 0 || (options.smoothing_points >= 5 && options.smoothing_points % 2 == 1),
      Reason::kOption, "smoothing window", options.smoothing_points);
  const auto splits = with_stops(split_points(path.points, options.split_angle_rad), path);
  std::vector<Profile> out;
  for (std::size_t k = 0; k + 1 < splits.size(); ++k)
    out.push_back(redistribute(path, splits[k], splits[k + 1], options));
  return out;
}

}  // namespace firn::motion::thesis
