#include "core/motion/kinematics/path_input.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

namespace firn::motion {
namespace {

constexpr double kSamePointMm = 1e-9;

inline void require_finite(double value, const char* what, std::size_t index, Point2 at) {
  if (std::isfinite(value)) [[likely]]
    return;
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

namespace {

/// Largest distance of a point from the curve that it is a sample of.
constexpr double kOnCurve_mm = 1e-6;

bool on_curve(const GivenCurve& curve, std::size_t i, Point2 p, double radius_mm) {
  if (curve.kind == GivenCurve::Kind::kArc)
    return std::abs(distance(curve.centre, p) - radius_mm) <= kOnCurve_mm + 1e-12 * radius_mm;
  const double share = double(i - curve.first) / double(curve.last - curve.first);
  return distance(curve.at(curve.from + share * (curve.to - curve.from)), p) <= kOnCurve_mm;
}

void require_given(const PathInput& in) {
  std::size_t before = 0;
  for (std::size_t k = 0; k < in.given.size(); ++k) {
    const GivenCurve& curve = in.given[k];
    bool good = before <= curve.first && curve.first < curve.last && curve.last < in.points.size();
    const double radius = good ? distance(curve.centre, in.points[curve.first]) : 0.0;
    good = good && (curve.kind == GivenCurve::Kind::kBezier || radius > 0.0);
    for (std::size_t i = curve.first; good && i <= curve.last; ++i)
      good = on_curve(curve, i, in.points[i], radius);
    before = curve.last;
    if (good) continue;
    Fault fault{Reason::kOption};
    fault.index = k;
    fault.what = "given curves";
    fault.value = double(curve.first);
    fault.bound = double(in.points.size());
    throw MotionError(fault);
  }
}

Point2 moved(Point2 p, Point2 by) { return {p.x_mm + by.x_mm, p.y_mm + by.y_mm}; }

/// Given curves in the base frame, with the indices of the points that are kept. One that loses a point is a
/// curve by its points alone.
void keep_given(const PathInput& in, const std::vector<std::size_t>& kept, CleanPath& path) {
  for (GivenCurve curve : in.given) {
    const std::size_t points = curve.last - curve.first;
    curve.first = kept[curve.first];
    curve.last = kept[curve.last];
    if (curve.last - curve.first != points) continue;
    for (Point2* p : {&curve.centre, &curve.start, &curve.control[0], &curve.control[1], &curve.end})
      *p = moved(*p, in.origin);
    path.given.push_back(curve);
  }
}

}  // namespace

CleanPath clean(const PathInput& in) {
  require_finite(in);
  const bool turning = yaw_varies(in);
  check_speed_limit(in.speed_limit, in.points.size());
  require_stops(in);
  require_given(in);
  const bool per_point = !in.speed_limit.point_mm_s.empty();
  CleanPath path;
  std::vector<double> speed_limit;
  std::vector<std::size_t> kept;  // of each point, where it is among the clean ones
  std::size_t stop = 0;
  const auto note_stop = [&](std::size_t k) {
    if (stop == in.stops.size() || in.stops[stop] != k) return;
    ++stop;
    const std::size_t at = path.points.size() - 1;
    if (at > 0 && (path.stops.empty() || path.stops.back() < at)) path.stops.push_back(at);
  };
  const std::size_t count = in.points.size() + (in.closed && !in.points.empty() ? 1 : 0);
  path.points.reserve(count);
  path.source.reserve(count);
  path.speed_limit_mm_s.reserve(count);
  speed_limit.reserve(count);
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t i = k < in.points.size() ? k : 0;
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
        if (!in.given.empty()) kept.push_back(path.points.size() - 1);
        note_stop(k);
        continue;
      }
    }
    path.points.push_back(p);
    path.source.push_back(i);
    if (!in.given.empty()) kept.push_back(path.points.size() - 1);
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
  keep_given(in, kept, path);
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
