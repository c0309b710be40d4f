#include "core/slice/paths/layer_paths.h"

#include "core/geometry/point_measures.h"

namespace firn::slice {
namespace {

double distance_mm(geometry::Point a, geometry::Point b) { return distance(a, b) * geometry::kMmPerUnit; }

// Roots of some steps side by side, sums in their order.
double length_mm(std::span<const geometry::Point> line, double length) {
  constexpr std::size_t kAtOnce = 16;
  while (line.size() > kAtOnce) {
    double steps[kAtOnce];
    for (std::size_t i = 0; i < kAtOnce; ++i) steps[i] = distance_mm(line[i], line[i + 1]);
    for (const double step : steps) length += step;
    line = line.subspan(kAtOnce);
  }
  for (std::size_t p = 1; p < line.size(); ++p) length += distance_mm(line[p - 1], line[p]);
  return length;
}

}  // namespace

std::vector<MaterialUse> material_use(const LayerPaths& paths) {
  std::vector<MaterialUse> use;
  for (std::size_t i = 0; i < paths.info.size(); ++i) {
    const PathInfo& info = paths.info[i];
    if (info.kind == PathKind::kMeasurement) continue;
    if (use.size() <= info.material) use.resize(std::size_t(info.material) + 1);
    const auto line = paths.lines[i];
    const double length = length_mm(line, info.closed ? distance_mm(line.back(), line.front()) : 0.0);
    use[info.material].length_mm += length;
    use[info.material].volume_mm3 +=
        length * (info.width * geometry::kMmPerUnit) * (paths.height * geometry::kMmPerUnit);
  }
  return use;
}

double transit_mm(const LayerPaths& paths) {
  double sum = 0;
  for (std::size_t i = 1; i < paths.info.size(); ++i) {
    const auto before = paths.lines[i - 1];
    sum += distance_mm(paths.info[i - 1].closed ? before.front() : before.back(), paths.lines[i].front());
  }
  return sum;
}

Path to_path(const LayerPaths& paths, std::size_t line) {
  const PathInfo& info = paths.info[line];
  Path path{paths.layer,
            info.material,
            info.kind,
            info.closed,
            info.width * geometry::kMmPerUnit,
            paths.height * geometry::kMmPerUnit,
            paths.z * geometry::kMmPerUnit,
            {}};
  path.points.reserve(paths.lines[line].size());
  for (const geometry::Point p : paths.lines[line])
    path.points.push_back({p.x * geometry::kMmPerUnit, p.y * geometry::kMmPerUnit});
  return path;
}

}  // namespace firn::slice
