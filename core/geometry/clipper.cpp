#include "core/geometry/clipper.h"

#include <algorithm>
#include <polyclipping/clipper.hpp>

namespace firn::geometry {
namespace {

ClipperLib::Paths to_paths(const Rings& rings) {
  ClipperLib::Paths paths(rings.size());
  for (std::size_t r = 0; r < rings.size(); ++r)
    for (const Point p : rings[r]) paths[r].push_back({p.x, p.y});
  return paths;
}

Rings to_rings(const ClipperLib::Paths& paths) {
  Rings rings;
  for (const ClipperLib::Path& path : paths) {
    if (path.size() < 3) continue;
    for (const ClipperLib::IntPoint& p : path) rings.points.push_back({std::int32_t(p.X), std::int32_t(p.Y)});
    rings.ends.push_back(std::uint32_t(rings.points.size()));
  }
  return rings;
}

}  // namespace

Rings clipper_offset(const Region& region, double inward_mm, double tolerance_mm) {
  ClipperLib::ClipperOffset offset(2.0, std::max(10.0, tolerance_mm * kUnitsPerMm));
  offset.AddPaths(to_paths(region), ClipperLib::jtRound, ClipperLib::etClosedPolygon);
  ClipperLib::Paths paths;
  offset.Execute(paths, -inward_mm * kUnitsPerMm);
  return to_rings(paths);
}

}  // namespace firn::geometry
