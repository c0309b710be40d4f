#include "core/slice/offset_rings.h"

#include "core/slice/clipper.h"
#include "core/slice/meeting.h"
#include "core/slice/wavefront.h"

namespace firn::slice {
namespace {

// Parallel walls a whole number of units apart would make fronts meet along their lengths; no wall does at this distance.
constexpr double kOdd = 0.2973;

// The front of one region on its way inward.
class Advance {
 public:
  explicit Advance(const Region& region) : front_(wavefront::front_of(region)) {}

  // @return false if the wavefront could not tell
  bool operator()(double to) {
    next_.clear();
    for (wavefront::Component& component : front_.components) {
      alive_.clear();
      for (const wavefront::Piece& piece : component.pieces) alive_.push_back(piece.source);
      move_(front_.sources, component, at_, to);
      if (!untangle_(front_.sources, alive_, component, to, next_)) return false;
    }
    std::swap(front_.components, next_);
    at_ = to;
    return true;
  }

  // At the asked tolerance, or finer where rings would meet. @return false if they meet even so
  bool draw(double tolerance, Rings& rings, std::uint32_t& finer) {
    for (int attempt = 0; attempt < 3; ++attempt, tolerance = attempt == 1 ? 0.2 * tolerance : 0) {
      rings.clear();
      for (const wavefront::Component& component : front_.components)
        wavefront::draw(front_.sources, component, at_, tolerance, line_, rings);
      const Meeting meeting = meeting_(rings);
      finer += attempt > 0;
      touching_ = meeting == Meeting::kContact;
      if (meeting == Meeting::kApart || (attempt == 2 && meeting == Meeting::kContact)) return true;
    }
    return false;
  }

  bool touching() const { return touching_; }  ///< may the rings drawn last have contacts?

 private:
  wavefront::Front front_;
  double at_ = 0;
  bool touching_ = false;
  wavefront::Mover move_;
  wavefront::Untangler untangle_;
  MeetingCheck meeting_;
  std::vector<wavefront::Component> next_;
  std::vector<std::int32_t> alive_;
  std::vector<Vec> line_;
};

}  // namespace

RingLevels offset_rings(const Region& region, const RingPlan& plan, double tolerance_mm) {
  RingLevels result;
  Advance advance(region);
  bool trusted = true;
  for (int level = 0; level < plan.max_rings; ++level) {
    Rings rings;
    if (trusted) {
      const double to = plan.distance_mm(level) * kUnitsPerMm + kOdd;
      trusted = advance(to) && advance.draw(tolerance_mm * kUnitsPerMm, rings, result.drawn_finer);
    }
    if (!trusted) {
      rings = clipper_offset(region, plan.distance_mm(level), tolerance_mm);
      ++result.from_clipper;
    }
    if (rings.empty()) break;
    result.levels.push_back(std::move(rings));
    result.touching.push_back(!trusted || advance.touching());
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
  Advance advance(around);
  Rings rings;
  std::uint32_t finer = 0;
  if (!advance(d) || !advance.draw(tolerance_mm * kUnitsPerMm, rings, finer))
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
