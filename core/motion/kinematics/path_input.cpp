#include "core/motion/kinematics/path_input.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

namespace firn::motion {
namespace {

constexpr double kSamePointMm = 1e-9;

void require_finite(double value, const char* what, std::size_t index, Point2 at) {
  if (std::isfinite(value)) return;
  Fault fault{Reason::kNotFinite};
  fault.index = index;
  fault.value = value;
  fault.at = at;
  fault.what = what;
  throw MotionError(fault);
}

void require_finite(const PathInput& in) {
  require_finite(in.origin.x_mm, "origin x", 0, {});
  require_finite(in.origin.y_mm, "origin y", 0, {});
  require_finite(in.z_mm, "z", 0, {});
  require_finite(in.yaw_rad, "yaw", 0, {});
  for (std::size_t i = 0; i < in.points.size(); ++i) {
    require_finite(in.points[i].x_mm, "x", i, in.points[i]);
    require_finite(in.points[i].y_mm, "y", i, in.points[i]);
  }
}

void require_stops(const PathInput& in) {
  for (std::size_t k = 0; k < in.stops.size(); ++k) {
    if (in.stops[k] < in.points.size() && (k == 0 || in.stops[k - 1] < in.stops[k])) continue;
    Fault fault{Reason::kOption};
    fault.index = k;
    fault.what = "stops";
    fault.value = double(in.stops[k]);
    fault.bound = double(in.points.size());
    throw MotionError(fault);
  }
}

}  // namespace

namespace {

[[noreturn]] void refuse_yaw(Reason reason, const PathInput& in, std::size_t index, double value,
                             double bound) {
  Fault fault{reason};
  fault.index = index;
  fault.value = value;
  fault.bound = bound;
  fault.what = "yaw";
  if (index < in.points.size()) fault.at = in.points[index];
  throw MotionError(fault);
}

/// The yaw at entry k of the path, which may be its first point again: then the nearest whole turn.
double yaw_at(const PathInput& in, std::size_t k) {
  const std::vector<double>& yaw = in.yaw_point_rad;
  if (k < yaw.size()) return yaw[k];
  constexpr double turn = 2.0 * std::numbers::pi;
  return yaw.front() + turn * std::nearbyint((yaw.back() - yaw.front()) / turn);
}

bool yaw_varies(const PathInput& in) {
  const std::vector<double>& yaw = in.yaw_point_rad;
  if (!yaw.empty() && yaw.size() != in.points.size())
    refuse_yaw(Reason::kYawSize, in, 0, double(yaw.size()), double(in.points.size()));
  for (std::size_t i = 0; i < yaw.size(); ++i) require_finite(yaw[i], "yaw", i, in.points[i]);
  return std::any_of(yaw.begin(), yaw.end(), [&](double y) { return y != yaw.front(); });
}

}  // namespace

CleanPath clean(const PathInput& in) {
  require_finite(in);
  const bool turning = yaw_varies(in);
  check_speed_limit(in.speed_limit, in.points.size());
  require_stops(in);
  const bool per_point = !in.speed_limit.point_mm_s.empty();
  CleanPath path;
  std::vector<double> speed_limit;
  std::size_t stop = 0;
  const auto note_stop = [&](std::size_t k) {
    if (stop == in.stops.size() || in.stops[stop] != k) return;
    ++stop;
    const std::size_t at = path.points.size() - 1;
    if (at > 0 && (path.stops.empty() || path.stops.back() < at)) path.stops.push_back(at);
  };
  const std::size_t count = in.points.size() + (in.closed && !in.points.empty() ? 1 : 0);
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t i = k % in.points.size();
    const Point2 p{in.points[i].x_mm + in.origin.x_mm, in.points[i].y_mm + in.origin.y_mm};
    const double limit =
        std::min(in.speed_limit.path_mm_s, per_point ? in.speed_limit.point_mm_s[i] : kUnlimited);
    if (!path.points.empty()) {
      const double dx = p.x_mm - path.points.back().x_mm, dy = p.y_mm - path.points.back().y_mm;
      if (std::sqrt(dx * dx + dy * dy) <= kSamePointMm) {
        constexpr double kSameYaw = 1e-9;
        if (turning && std::abs(yaw_at(in, k) - path.yaw_rad.back()) > kSameYaw)
          refuse_yaw(Reason::kYawJump, in, i, yaw_at(in, k), path.yaw_rad.back());
        speed_limit.back() = std::min(speed_limit.back(), limit);
        note_stop(k);
        continue;
      }
    }
    path.points.push_back(p);
    path.source.push_back(i);
    if (turning) path.yaw_rad.push_back(yaw_at(in, k));
    speed_limit.push_back(limit);
    note_stop(k);
  }
  if (!path.stops.empty() && path.stops.back() + 1 == path.points.size()) path.stops.pop_back();
  if (path.points.size() < 2) {
    Fault fault{Reason::kTooFewPoints};
    fault.value = double(path.points.size());
    fault.bound = 2.0;
    if (!in.points.empty()) fault.at = in.points[0];
    throw MotionError(fault);
  }
  for (std::size_t i = 0; i + 1 < path.points.size(); ++i)
    path.speed_limit_mm_s.push_back(std::min(speed_limit[i], speed_limit[i + 1]));
  return path;
}

std::vector<std::size_t> with_stops(const std::vector<std::size_t>& splits, const CleanPath& path) {
  std::vector<std::size_t> all;
  std::set_union(splits.begin(), splits.end(), path.stops.begin(), path.stops.end(), std::back_inserter(all));
  return all;
}

}  // namespace firn::motion
