#include "core/slice/paths/hook.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/geometry/planar.h"
#include "core/geometry/point_measures.h"
#include "core/geometry/vec.h"
#include "core/slice/offset/offset_rings.h"

namespace firn::slice {
namespace {

double doubled_area(std::span<const geometry::Point> ring) {
  double sum = 0;
  for (std::size_t i = 1; i + 1 < ring.size(); ++i)
    sum += cross(to_vec(ring[i]) - to_vec(ring[0]), to_vec(ring[i + 1]) - to_vec(ring[0]));
  return sum;
}

bool runs_round_everything(std::span<const geometry::Point> ring, const geometry::Region& part) {
  if (doubled_area(ring) <= 0) return false;
  for (std::size_t r = 0; r < part.size(); ++r)
    if (doubled_area(part[r]) > 0 && encloses<geometry::Point>(part[r], ring[0])) return false;
  return true;
}

// Returns whether each outer ring of the part lies inside one of the hooks; otherwise hooks run along the
// part and not around it.
bool encloses(const geometry::Rings& hooks, const geometry::Region& part) {
  for (std::size_t r = 0; r < part.size(); ++r) {
    if (doubled_area(part[r]) <= 0) continue;
    bool enclosed = false;
    for (std::size_t h = 0; h < hooks.size() && !enclosed; ++h)
      enclosed = encloses<geometry::Point>(hooks[h], part[r][0]);
    if (!enclosed) return false;
  }
  return true;
}

// Returns the distance between rings that do not cross: from the corners of each to the edges of the other.
double distance_mm(const geometry::Rings& a, const geometry::Rings& b) {
  double best = std::numeric_limits<double>::infinity();
  const auto corners_to_edges = [&](const geometry::Rings& corners, const geometry::Rings& edges) {
    for (const geometry::Point p : corners.points)
      for (std::size_t r = 0; r < edges.size(); ++r)
        for (std::size_t i = 0; i < edges[r].size(); ++i)
          best = std::min(best, square_distance(to_vec(p), to_vec(edges[r][i]),
                                                to_vec(edges[r][(i + 1) % edges[r].size()])));
  };
  corners_to_edges(a, b);
  corners_to_edges(b, a);
  return std::sqrt(best) * geometry::kMmPerUnit;
}

}  // namespace

int hooks_in(std::int32_t layer, const HookOptions& options) {
  if (!options.on || layer < 1 || layer > options.last_layer) return 0;
  return layer <= options.two_from_layer ? 1 : 2;
}

geometry::Rings take_outermost(geometry::Rings& rings, const geometry::Region& part) {
  geometry::Rings taken, left;
  for (std::size_t r = 0; r < rings.size(); ++r)
    (runs_round_everything(rings[r], part) ? taken : left).add(rings[r]);
  rings = std::move(left);
  return taken;
}

geometry::Region room_for_hook(const geometry::Region& scaffold, const geometry::Region& part, int hooks,
                               const PathOptions& options) {
  const ExtrusionOptions& extrusion = options.scaffold;
  if (part.empty()) return scaffold;
  const geometry::Rings everything = unite(scaffold, part);
  geometry::Region wider = scaffold;
  // The distance of the innermost hook of contours that extend out_mm beyond everything is out_mm less its
  // own distance from the outer edge: this many contours suffice for any part.
  const RingPlan hook_rings{extrusion.first_offset_mm, extrusion.boundaries, extrusion.boundary_width_mm,
                            extrusion.fill_width_mm};
  const double enough_mm = hook_rings.distance_mm(hooks - 1) + 0.5 * hook_rings.width_mm(hooks - 1) +
                           options.hook.clearance_mm + 2 * options.chord_tolerance_mm;
  const int most = int(std::ceil(enough_mm / extrusion.boundary_width_mm));
  for (int contours = 0; contours <= most; ++contours) {
    if (contours > 0) {
      const double out_mm = contours * extrusion.boundary_width_mm;
      wider = subtract(grow(everything, out_mm, options.chord_tolerance_mm), part);
    }
    RingPlan plan{extrusion.first_offset_mm, extrusion.boundaries, extrusion.boundary_width_mm,
                  extrusion.fill_width_mm, hooks};
    RingLevels rings = offset_rings(wider, plan, options.chord_tolerance_mm);
    bool clear = int(rings.levels.size()) == hooks;
    for (int level = 0; clear && level < hooks; ++level) {
      const geometry::Rings hook = take_outermost(rings.levels[std::size_t(level)], part);
      const double width =
          level < extrusion.boundaries ? extrusion.boundary_width_mm : extrusion.fill_width_mm;
      clear = encloses(hook, part) && distance_mm(hook, part) >= 0.5 * width + options.hook.clearance_mm;
    }
    if (clear) break;
  }
  return wider;
}

}  // namespace firn::slice
