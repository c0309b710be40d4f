#include "core/slice/offset_rings.h"

#include "core/slice/box_pairs.h"
#include "core/slice/clipper.h"
#include "core/slice/wavefront.h"

namespace firn::slice {
namespace {

// Parallel walls a whole number of units apart would make fronts meet along their lengths; no wall does at this distance.
constexpr double kOdd = 0.2973;

// @return false if the wavefront could not tell
bool advance(const wavefront::Front& front, std::vector<wavefront::Component>& components, double from, double to) {
  std::vector<wavefront::Component> next;
  std::vector<std::int32_t> alive;
  BoxTree<double> boxes;
  for (wavefront::Component& component : components) {
    alive.clear();
    for (const wavefront::Piece& piece : component.pieces) alive.push_back(piece.source);
    wavefront::move(front.sources, component, from, to);
    if (!wavefront::untangle(front.sources, alive, component, to, boxes, next)) return false;
  }
  components = std::move(next);
  return true;
}

// At the asked tolerance, or finer where rings would meet. @return false if they meet even so
bool draw_level(const wavefront::Front& front, const std::vector<wavefront::Component>& components, double d,
                double tolerance, Rings& rings, std::uint32_t& finer) {
  for (int attempt = 0; attempt < 3; ++attempt, tolerance = attempt == 1 ? 0.2 * tolerance : 0) {
    rings.clear();
    for (const wavefront::Component& component : components)
      wavefront::draw(front.sources, component, d, tolerance, rings);
    const Meeting meeting = meeting_of(rings);
    finer += attempt > 0;
    if (meeting == Meeting::kApart || (attempt == 2 && meeting == Meeting::kContact)) return true;
  }
  return false;
}

}  // namespace

RingLevels offset_rings(const Region& region, const RingPlan& plan, double tolerance_mm) {
  RingLevels result;
  wavefront::Front front = wavefront::front_of(region);
  double at = 0;
  bool trusted = true;
  for (int level = 0; level < plan.max_rings; ++level) {
    Rings rings;
    if (trusted) {
      const double to = plan.distance_mm(level) * kUnitsPerMm + kOdd;
      trusted = advance(front, front.components, at, to) &&
                draw_level(front, front.components, to, tolerance_mm * kUnitsPerMm, rings, result.drawn_finer);
      at = to;
    }
    if (!trusted) {
      rings = clipper_offset(region, plan.distance_mm(level), tolerance_mm);
      ++result.from_clipper;
    }
    if (rings.empty()) break;
    result.levels.push_back(std::move(rings));
  }
  return result;
}

Region grow(const Region& region, double outward_mm, double tolerance_mm) {
  if (region.empty()) return {};
  // What lies around the region, bounded far outside: every ring turned, and a frame.
  const double d = outward_mm * kUnitsPerMm + kOdd;
  BoxOf<std::int32_t> box;
  for (const Point p : region.points) box.add(p.x, p.y);
  const std::int32_t far = std::int32_t(3 * d) + 10 * kUnitsPerMm;
  Region around;
  const Point frame[] = {{box.x0 - far, box.y0 - far}, {box.x1 + far, box.y0 - far}, {box.x1 + far, box.y1 + far},
                         {box.x0 - far, box.y1 + far}};
  around.add(frame);
  std::vector<Point> ring;
  for (std::size_t r = 0; r < region.size(); ++r) {
    ring.assign(region[r].rbegin(), region[r].rend());
    around.add(ring);
  }
  wavefront::Front front = wavefront::front_of(around);
  Rings rings;
  std::uint32_t finer = 0;
  if (!advance(front, front.components, 0, d) ||
      !draw_level(front, front.components, d, tolerance_mm * kUnitsPerMm, rings, finer))
    return clipper_offset(region, -outward_mm, tolerance_mm);
  // Turn back, without the frame: the ring that reaches furthest out.
  Region grown;
  const std::int32_t frame_x = box.x0 - std::int32_t(1.5 * d) - 5 * kUnitsPerMm;
  for (std::size_t r = 0; r < rings.size(); ++r) {
    if (rings[r][0].x < frame_x || rings[r][1].x < frame_x) continue;
    ring.assign(rings[r].rbegin(), rings[r].rend());
    grown.add(ring);
  }
  return grown;
}

}  // namespace firn::slice
