#include "core/geometry/clipper.h"

#include <algorithm>
#include <polyclipping/clipper.hpp>

namespace firn::slice {
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

Rings combine(ClipperLib::ClipType type, const Rings& a, const Rings& b) {
  ClipperLib::Clipper clipper;
  clipper.AddPaths(to_paths(a), ClipperLib::ptSubject, true);
  clipper.AddPaths(to_paths(b), ClipperLib::ptClip, true);
  ClipperLib::Paths paths;
  clipper.Execute(type, paths, ClipperLib::pftPositive, ClipperLib::pftPositive);
  return to_rings(paths);
}

}  // namespace

Rings clipper_offset(const Region& region, double inward_mm, double tolerance_mm) {
  ClipperLib::ClipperOffset offset(2.0, std::max(10.0, tolerance_mm * kUnitsPerMm));
  offset.AddPaths(to_paths(region), ClipperLib::jtRound, ClipperLib::etClosedPolygon);
  ClipperLib::Paths paths;
  offset.Execute(paths, -inward_mm * kUnitsPerMm);
  return to_rings(paths);
}

Rings clipper_unite(const Rings& a, const Rings& b) { return combine(ClipperLib::ctUnion, a, b); }
Rings clipper_subtract(const Rings& a, const Rings& b) { return combine(ClipperLib::ctDifference, a, b); }

}  // namespace firn::slice
