#include "core/motion/constant_speed.h"

#include <algorithm>
#include <cmath>

#include "core/motion/kinematics/placement.h"
#include "core/motion/kinematics/require.h"
#include "core/motion/thesis/pathsplit.h"

namespace firn::motion {
namespace {

/// Points first..last of the path at whole ticks, without the first one.
void emit(const CleanPath& path, std::size_t first, std::size_t last, double speed_mm_s,
          const ConstantOptions& options, thesis::Profile& samples) {
  thesis::Profile piece;
  std::vector<double> speed_limit;
  for (std::size_t i = first; i <= last; ++i) {
    piece.points.push_back(path.points[i]);
    piece.s_mm.push_back(i == first ? 0.0 : piece.s_mm.back() + distance(path.points[i - 1], path.points[i]));
    if (!path.yaw_rad.empty()) piece.yaw_rad.push_back(path.yaw_rad[i]);
    if (i < last) speed_limit.push_back(std::min(speed_mm_s, path.speed_limit_mm_s[i]));
  }
  const RampedSpeed law(piece.s_mm, speed_limit, options.ramp_mm_s2);
  const double ticks = double(whole_ticks(law.duration_s(), options.tick_s));
  for (double n = 1.0; n <= ticks; ++n)
    append_at(piece, law.distance_at(law.duration_s() * (n / ticks)), samples);
}

bool straight_between(const std::vector<Point2>& p, const std::vector<std::size_t>& stops) {
  constexpr double kStraightSine = 1e-3;
  std::size_t next = 1;
  for (std::size_t i = 1; i + 1 < p.size(); ++i) {
    if (i == stops[next]) {
      ++next;
      continue;
    }
    const double ax = p[i].x_mm - p[i - 1].x_mm, ay = p[i].y_mm - p[i - 1].y_mm;
    const double bx = p[i + 1].x_mm - p[i].x_mm, by = p[i + 1].y_mm - p[i].y_mm;
    if (std::abs(ax * by - ay * bx) > kStraightSine * std::sqrt((ax * ax + ay * ay) * (bx * bx + by * by)))
      return false;
  }
  return true;
}

}  // namespace

std::vector<std::size_t> fill_stops(const std::vector<Point2>& points, PathKind kind,
                                    double split_angle_rad) {
  const std::vector<std::size_t> ends{0, points.size() - 1};
  if (kind != PathKind::kFill) return ends;
  auto stops = thesis::split_points(points, split_angle_rad);
  return straight_between(points, stops) ? stops : ends;
}

RampedSpeed::RampedSpeed(const std::vector<double>& s, const std::vector<double>& speed_limit, double ramp) {
  const std::size_t n = s.size();
  std::vector<double> v(n, 0.0);  // at the points: below both speed limits, reachable from both sides
  for (std::size_t i = 1; i + 1 < n; ++i)
    v[i] = std::min({speed_limit[i - 1], speed_limit[i],
                     std::sqrt(v[i - 1] * v[i - 1] + 2.0 * ramp * (s[i] - s[i - 1]))});
  for (std::size_t i = n - 1; i-- > 0;)
    v[i] = std::min(v[i], std::sqrt(v[i + 1] * v[i + 1] + 2.0 * ramp * (s[i + 1] - s[i])));
  for (std::size_t i = 0; i + 1 < n; ++i) {
    const double ds = s[i + 1] - s[i], a2 = v[i] * v[i], b2 = v[i + 1] * v[i + 1];
    const double top =
        std::min(speed_limit[i], std::sqrt(std::max(0.5 * (a2 + b2) + ramp * ds, std::max(a2, b2))));
    add((top - v[i]) / ramp, v[i], ramp);
    add(std::max(0.0, ds - (2.0 * top * top - a2 - b2) / (2.0 * ramp)) / top, top, 0.0);
    add((top - v[i + 1]) / ramp, top, -ramp);
  }
}

void RampedSpeed::add(double duration, double speed, double acceleration) {
  if (!(duration > 0.0)) return;
  phases_.push_back({end_s_, end_mm_, speed, acceleration});
  end_s_ += duration;
  end_mm_ += (speed + 0.5 * acceleration * duration) * duration;
}

double RampedSpeed::distance_at(double t) const {
  if (t >= end_s_) return end_mm_;
  std::size_t low = 0, high = phases_.size();
  while (high - low > 1) {
    const std::size_t middle = (low + high) / 2;
    (phases_[middle].t_s <= t ? low : high) = middle;
  }
  const Phase& p = phases_[low];
  const double dt = std::max(0.0, t - p.t_s);
  return p.s_mm + (p.speed_mm_s + 0.5 * p.acceleration_mm_s2 * dt) * dt;
}

Trajectory plan_constant(const PathInput& input, const Arm& arm, const MotionLimits& limits,
                         const ConstantOptions& options) {
  check_limits(limits, arm.joints());
  require_positive(options.boundary_mm_s, "boundary speed");
  require_positive(options.fill_mm_s, "fill speed");
  require_positive(options.ramp_mm_s2, "ramp");
  require_positive(options.split_angle_rad, "split angle");
  require_positive(options.tick_s, "tick");
  const CleanPath path = clean(input);
  const ArmConfiguration configuration = configuration_for(path, input, arm);
  auto stops = fill_stops(path.points, input.kind, options.split_angle_rad);
  const bool fill = input.kind == PathKind::kFill && straight_between(path.points, stops);
  const double speed = std::min(limits.position.rate, fill ? options.fill_mm_s : options.boundary_mm_s);
  stops = with_stops(stops, path);
  thesis::Profile samples;
  samples.points.push_back(path.points.front());
  if (!path.yaw_rad.empty()) samples.yaw_rad.push_back(path.yaw_rad.front());
  for (std::size_t k = 0; k + 1 < stops.size(); ++k)
    emit(path, stops[k], stops[k + 1], speed, options, samples);
  return trajectory_of(
      joints_at(samples.points, samples.yaw_rad, arm.joints(), path, input, arm, configuration), arm,
      options.tick_s);
}

}  // namespace firn::motion
