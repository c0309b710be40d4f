#include "studies/reproduce/barnett/build_time.h"

#include <cmath>
#include <map>

#include "core/motion/constant_speed.h"
#include "core/motion/thesis/thesis.h"
#include "core/path/polyline.h"
#include "print/prepare/slice_job.h"
#include "runtime/thread_pool.h"

namespace firn::barnett {
namespace {

constexpr double kMin_mm = 0.4;  // the thesis's sampling (4.2.2)

// The arm's places of rest before and after a path: its ends, or `run_mm` beyond them.
struct Ends {
  Point2 first, last;
};
Ends ends_of(const std::vector<Point2>& points, bool closed, double run_mm) {
  const auto beyond = [&](const Point2& end, const Point2& inside) {
    const double length = distance(inside, end);
    if (length <= 0.0) return end;
    return Point2{end.x_mm + run_mm * (end.x_mm - inside.x_mm) / length,
                  end.y_mm + run_mm * (end.y_mm - inside.y_mm) / length};
  };
  if (closed) return {points.front(), points.front()};
  return {beyond(points.front(), points[1]), beyond(points.back(), points[points.size() - 2])};
}

// From rest to `speed`.
double ramp_s(double speed, const motion::RateLimits& l) {
  return speed / l.acceleration + l.acceleration / l.jerk;
}

}  // namespace

double rest_to_rest_s(double distance_mm, const motion::RateLimits& l) {
  const double knee_s = l.acceleration / l.jerk;
  if (distance_mm <= 2.0 * l.acceleration * knee_s * knee_s)
    return 4.0 * std::cbrt(distance_mm / (2.0 * l.jerk));
  const double reached =
      0.5 * l.acceleration * (std::sqrt(knee_s * knee_s + 4.0 * distance_mm / l.acceleration) - knee_s);
  if (reached <= l.rate) return 2.0 * ramp_s(reached, l);
  return distance_mm / l.rate + ramp_s(l.rate, l);
}

std::int64_t BuildPaths::count() const {
  std::int64_t n = 0;
  for (const BuildPath& p : paths) n += p.count;
  return n;
}

double BuildPaths::length_mm() const {
  double length = 0.0;
  for (const BuildPath& p : paths) length += p.length_mm * double(p.count);
  return length;
}

BuildPaths build_paths(const BoxFolder& folder, const motion::RateLimits& limits,
                       const std::vector<std::string>& overrides, int threads) {
  const SliceSettings settings = load_slice_settings(folder.path / "slice.toml", overrides);
  const ParallelFor parallel = parallel_on(threads);
  const auto silent = [](double, const std::string&) {};
  SlicedJob job = slice_meshes({folder.path / "box.stl"}, settings, parallel, silent);
  std::map<std::vector<std::int32_t>, std::size_t> known;
  BuildPaths all;
  const double ramp = ramp_s(limits.rate, limits), run_mm = 0.5 * limits.rate * ramp;
  plan_layers(job, settings, parallel, silent, {}, [&](PlannedLayer&& l) {
    ++all.layers;
    std::vector<Ends> at_rest[2];
    for (const slice::MaterialUse& u : l.use) all.volume_mm3 += u.volume_mm3;
    for (std::size_t n = 0; n < l.paths.info.size(); ++n) {
      const slice::PathInfo& info = l.paths.info[n];
      const auto line = l.paths.lines[n];
      if (info.kind == PathKind::kMeasurement || line.size() < 2) continue;
      std::vector<std::int32_t> key{std::int32_t(info.kind), info.closed, info.material};
      std::vector<Point2> points;
      for (const geometry::Point& p : line)
        points.push_back({p.x * geometry::kMmPerUnit, p.y * geometry::kMmPerUnit});
      const double length = path_length_mm(points, info.closed);
      if (length < kMin_mm) continue;
      const bool straight = info.kind == PathKind::kFill && points.size() == 2 && !info.closed;
      at_rest[0].push_back(ends_of(points, info.closed, 0.0));
      at_rest[1].push_back(ends_of(points, info.closed, straight ? run_mm : 0.0));
      if (straight) all.run_up_s += 2.0 * ramp + length / limits.rate - rest_to_rest_s(length, limits);
      for (const geometry::Point& p : line) key.insert(key.end(), {p.x, p.y});
      const auto [at, fresh] = known.try_emplace(std::move(key), all.paths.size());
      if (fresh) {
        all.paths.push_back({info.kind, info.closed, info.material, std::move(points), length, 0});
      }
      ++all.paths[at->second].count;
    }
    double way_s[2]{};
    for (int k = 0; k < 2; ++k)
      for (std::size_t n = 1; n < at_rest[k].size(); ++n)
        way_s[k] += rest_to_rest_s(distance(at_rest[k][n - 1].last, at_rest[k][n].first), limits);
    all.transit_s += way_s[0];
    all.run_up_s += way_s[1] - way_s[0];
  });
  return all;
}

double motion_s(const BuildPaths& of, const std::function<double(const motion::PathInput&)>& duration_s) {
  double sum = 0.0;
  for (const BuildPath& p : of.paths) {
    motion::PathInput in{.points = p.points};
    in.kind = p.kind;
    in.closed = p.closed;
    in.origin = kBoxPlace;
    sum += double(p.count) * duration_s(in);
  }
  return sum;
}

double duration_s(Way way, const motion::PathInput& in, const motion::Arm& arm,
                  const motion::MotionLimits& limits) {
  motion::ConstantOptions constant;
  constant.fill_mm_s = way == Way::kStraightConstant ? 125.0 : 25.0;  // 4.4
  const Trajectory t =
      way == Way::kVariable ? plan_thesis(in, arm, limits) : plan_constant(in, arm, limits, constant);
  return t.tick_s * double(t.samples() - 1);
}

}  // namespace firn::barnett
