// From the lines of a layer to tasks.
#include <algorithm>
#include <cmath>

#include "core/path/polyline.h"
#include "core/planning/path_planning.h"
#include "core/slice/coverage/footprint.h"

namespace firn::planning {
namespace {

constexpr double kCoverageCell_mm = 1.0, kWidestSpot_mm = 2.0;
constexpr double kShortest_mm = 0.05;  // a line that is shorter deposits nothing and cannot be driven

PathTask task_of(const slice::PrintPaths& paths, const slice::LayerPaths& layer, std::size_t n,
                 const PlanningSetup& setup) {
  PathTask t{slice::to_path(layer, n), "laser", nullptr};
  if (t.deposits()) {
    t.z_mm += setup.nozzle_gap_mm;
    t.tool = paths.head.materials.at(t.material).tool;
  }
  return t;
}

/// Equal pieces of a path, each open, from where the one before ends.
void divide(PathTask task, double max_mm, std::vector<PathTask>& out) {
  const double length = path_length_mm(task.points, task.closed);
  const int pieces = int(std::ceil(length / max_mm));
  if (pieces <= 1) return out.push_back(std::move(task));
  std::vector<Point2> points = std::move(task.points);
  if (task.closed) points.push_back(points.front());
  task.closed = false;
  double done = 0.0;
  task.points = {points.front()};
  for (std::size_t i = 1, piece = 1; i < points.size();) {
    const double step = distance(points[i - 1], points[i]), end = length * double(piece) / pieces;
    if (int(piece) < pieces && done + step > end) {
      const double share = (end - done) / step;
      const Point2 cut{points[i - 1].x_mm + share * (points[i].x_mm - points[i - 1].x_mm),
                       points[i - 1].y_mm + share * (points[i].y_mm - points[i - 1].y_mm)};
      task.points.push_back(cut);
      out.push_back(task);
      task.points = {cut};
      points[i - 1] = cut;
      done = end;
      ++piece;
    } else {
      task.points.push_back(points[i++]);
      done += step;
    }
  }
  out.push_back(std::move(task));
}

}  // namespace

std::vector<Point2> subdivided(const std::vector<Point2>& p, bool closed, double step_mm) {
  std::vector<Point2> out;
  const std::size_t segments = p.size() < 2 ? 0 : p.size() - (closed ? 0 : 1);
  for (std::size_t i = 0; i < segments; ++i) {
    const Point2 &a = p[i], &b = p[(i + 1) % p.size()];
    const int parts = std::max(1, int(std::ceil(distance(a, b) / step_mm)));
    for (int k = 0; k < parts; ++k) {
      const double t = double(k) / parts;
      out.push_back({a.x_mm + t * (b.x_mm - a.x_mm), a.y_mm + t * (b.y_mm - a.y_mm)});
    }
  }
  if (!closed && !p.empty()) out.push_back(p.back());
  return out;
}

std::vector<PathTask> tasks_of(const slice::PrintPaths& paths, const slice::LayerPaths& layer,
                               bool measurement, const PlanningSetup& setup) {
  std::vector<PathTask> tasks;
  std::shared_ptr<HeightMap> excess;
  if (!measurement && setup.coverage_window_mm > 0.0) {
    excess = std::make_shared<HeightMap>(slice::extrusion_coverage(
        layer, slice::footprint_grid(layer, kCoverageCell_mm), setup.coverage_window_mm, kWidestSpot_mm));
    for (double& c : excess->cells) c -= 1.0;
  }
  for (std::size_t n = 0; n < layer.info.size(); ++n) {
    if ((layer.info[n].kind == PathKind::kMeasurement) != measurement) continue;
    PathTask task = task_of(paths, layer, n, setup);
    if (path_length_mm(task.points, task.closed) < kShortest_mm) continue;
    if (!measurement) {
      task.excess = excess;
      tasks.push_back(std::move(task));
      continue;
    }
    const double speed =
        std::min(setup.speeds.at(std::min<std::size_t>(task.material, 1)).measure_mm_s, setup.arm.speed_mm_s);
    divide(std::move(task), 0.8 * speed * setup.valve_limits.max_duration_s, tasks);
  }
  return tasks;
}

}  // namespace firn::planning
