#include "core/motion/vplus_default.h"

#include <algorithm>
#include <cmath>

#include "core/exact/exact_math.h"
#include "core/motion/kinematics/placement.h"
#include "core/motion/kinematics/require.h"
#include "core/motion/thesis/profile.h"

namespace firn::motion {
namespace {

constexpr double kStraightRad = 1e-4;  ///< a smaller turn is rounding of coordinates
constexpr double kCornerRad = 0.5235987755982988;

double turn_at(const std::vector<Point2>& p, std::size_t i) {
  const double ax = p[i].x_mm - p[i - 1].x_mm, ay = p[i].y_mm - p[i - 1].y_mm;
  const double bx = p[i + 1].x_mm - p[i].x_mm, by = p[i + 1].y_mm - p[i].y_mm;
  return std::abs(exact::atan2(ax * by - ay * bx, ax * bx + ay * by));
}

/// Bend of the yaw at a point, as of a direction: the change of its slope over the mean of both
/// segments.
double yaw_bend_at(const CleanPath& path, std::size_t i) {
  if (path.yaw_rad.empty()) return 0.0;
  const double before = distance(path.points[i - 1], path.points[i]),
               after = distance(path.points[i], path.points[i + 1]);
  const double slope = (path.yaw_rad[i] - path.yaw_rad[i - 1]) / before,
               next = (path.yaw_rad[i + 1] - path.yaw_rad[i]) / after;
  return std::abs(next - slope) * 0.5 * (before + after);
}

struct Moves {
  std::vector<Point2> points;
  std::vector<double> yaw_rad;     ///< at the points; empty where it is constant
  std::vector<double> speed_mm_s;  ///< allowed on each move
  double duration_s(double blend) const {
    double sum = blend;
    for (std::size_t i = 0; i + 1 < points.size(); ++i) sum += move_s(i, blend);
    return sum;
  }
  double move_s(std::size_t i, double blend) const {
    return std::max(distance(points[i], points[i + 1]) / speed_mm_s[i], blend);
  }
};

Moves moves_of(const CleanPath& path, const MotionLimits& limits, double spacing) {
  const auto support = supporting_points(path, spacing);
  Moves moves;
  for (std::size_t k = 0; k < support.size(); ++k) {
    moves.points.push_back(path.points[support[k]]);
    if (!path.yaw_rad.empty()) moves.yaw_rad.push_back(path.yaw_rad[support[k]]);
    if (k == 0) continue;
    double speed = limits.position.rate;
    for (std::size_t i = support[k - 1]; i < support[k]; ++i)
      speed = std::min(speed, path.speed_limit_mm_s[i]);
    moves.speed_mm_s.push_back(speed);
  }
  return moves;
}

/// Tool points, and yaws, at the whole ticks: lines, and parabolas of length t_b around each point.
Moves sample(const Moves& m, double blend, double tick_s) {
  const std::size_t n = m.points.size();
  std::vector<double> at(n, 0.5 * blend);
  for (std::size_t i = 0; i + 1 < n; ++i) at[i + 1] = at[i] + m.move_s(i, blend);
  const double duration = m.duration_s(blend), ticks = double(whole_ticks(duration, tick_s));
  Moves samples;
  std::size_t i = 0;
  for (double k = 0.0; k <= ticks; ++k) {
    const double t = duration * (k / ticks);
    while (i + 1 < n && t > at[i + 1] - 0.5 * blend) ++i;
    const double after = t - at[i],
                 into = after + 0.5 * blend;  // since the middle and since the start of the blend
    const double f = into < blend ? into * into / (2.0 * blend) : after;
    const double base = into < blend ? after : 0.0;
    const auto follow = [&](auto coordinate) {
      const double before = i > 0 ? (coordinate(i) - coordinate(i - 1)) / m.move_s(i - 1, blend) : 0.0;
      const double behind = i + 1 < n ? (coordinate(i + 1) - coordinate(i)) / m.move_s(i, blend) : 0.0;
      return coordinate(i) + before * base + (into < blend ? behind - before : behind) * f;
    };
    samples.points.push_back({follow([&](std::size_t p) { return m.points[p].x_mm; }),
                              follow([&](std::size_t p) { return m.points[p].y_mm; })});
    if (!m.yaw_rad.empty()) samples.yaw_rad.push_back(follow([&](std::size_t p) { return m.yaw_rad[p]; }));
  }
  samples.points.back() = m.points.back();
  if (!m.yaw_rad.empty()) samples.yaw_rad.back() = m.yaw_rad.back();
  return samples;
}

void check(const DefaultOptions& options) {
  require_positive(options.blend_s, "blend time");
  require(options.support_spacing_mm >= 0.0 && std::isfinite(options.support_spacing_mm), Reason::kOption,
          "support spacing", options.support_spacing_mm);
  require_positive(options.tick_s, "tick");
}

}  // namespace

std::vector<std::size_t> supporting_points(const CleanPath& path, double spacing) {
  const auto& p = path.points;
  std::vector<std::size_t> out{0};
  if (spacing <= 0.0) {
    for (std::size_t i = 1; i < p.size(); ++i) out.push_back(i);
    return out;
  }
  double since = 0.0;  // along the path from the last supporting point
  bool straight = true;
  for (std::size_t i = 1; i + 1 < p.size(); ++i) {
    since += distance(p[i - 1], p[i]);
    const double turn = std::max(turn_at(p, i), yaw_bend_at(path, i));
    const bool bends = turn > kStraightRad,
               ends_here =
                   i + 2 < p.size() && std::max(turn_at(p, i + 1), yaw_bend_at(path, i + 1)) <= kStraightRad;
    const bool first_of_bend = bends && straight;
    straight = !bends;
    if (!bends || !(first_of_bend || ends_here || turn > kCornerRad || since >= spacing * (1.0 - 1e-9)))
      continue;
    out.push_back(i);
    since = 0.0;
  }
  out.push_back(p.size() - 1);
  return out;
}

Trajectory plan_default(const PathInput& input, const Arm& arm, const MotionLimits& limits,
                        const DefaultOptions& options) {
  check_limits(limits, arm.joints());
  check(options);
  const CleanPath path = clean(input);
  const ArmConfiguration configuration = configuration_for(path, input, arm);
  const Moves moves = moves_of(path, limits, options.support_spacing_mm);
  const auto samples = sample(moves, options.blend_s, options.tick_s);
  return trajectory_of(
      joints_at(samples.points, samples.yaw_rad, arm.joints(), path, input, arm, configuration), arm,
      options.tick_s);
}

double blend_for_duration(const PathInput& input, const MotionLimits& limits, const DefaultOptions& options,
                          double duration_s) {
  check(options);
  const Moves moves = moves_of(clean(input), limits, options.support_spacing_mm);
  Fault fault(Reason::kNoSolution);
  fault.what = "duration of the default technique";
  fault.value = duration_s;
  fault.bound = moves.duration_s(0.0);
  if (!(duration_s > fault.bound)) throw MotionError(fault);
  double low = 0.0, high = duration_s;  // the duration grows by at least the blend itself
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (low + high);
    (moves.duration_s(middle) < duration_s ? low : high) = middle;
  }
  return high;
}

}  // namespace firn::motion
