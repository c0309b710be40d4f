#include "core/slice/offset_rings.h"

#include <algorithm>
#include <optional>

#include "core/slice/clipper.h"
#include "core/slice/gap_band.h"
#include "core/slice/lacks.h"
#include "core/slice/meeting.h"
#include "core/slice/path_filter.h"
#include "core/slice/planar.h"
#include "core/slice/rings.h"
#include "core/slice/wavefront.h"

namespace firn::slice {
namespace {

// Parallel walls a whole number of units apart would make fronts meet along their lengths; no wall does at this distance.
// Where the front of one distance cannot tell which of its places coincide, that of another can.
constexpr double kOdd[] = {0.2973, 1.6131, 3.1429};
constexpr double kAgain = 0.1;   // of what was thinned, where areas depend on it
constexpr double kNarrow = 4.0;  // of the way to the next level: half the width of strips that look narrow

// The front of one region on its way inward.
class Advance {
 public:
  explicit Advance(const Region& region, const Thinned& thinned = {}) : front_(wavefront::front_of(region)) {
    if (thinned.from && !thinned.from->empty()) tips_.emplace(*thinned.from, thinned.by_mm * kUnitsPerMm);
  }

  // @return false if the wavefront could not tell
  bool operator()(double to) {
    next_.clear();
    for (wavefront::Component& component : front_.components)
      if (!move(component, at_, to, next_)) return false;
    arrive(to);
    return true;
  }

  // The same; tells what of the front lacks the next one. Areas of the rings drawn last that look too narrow for the next ones
  // are looked at on the way.
  // @param core where, or beyond `to`: none are
  bool telling(double core, double to, const Rings& drawn, const GapLimits& limits, const GapLimits& core_limits, double sagitta,
               LevelGaps& gaps) {
    next_.clear(), cores_.clear();
    for (std::size_t c = 0, ring = 0; c < front_.components.size(); ++c) {
      wavefront::Component& component = front_.components[c];
      const std::size_t end = core < to ? drawn_ends_[c] : 0;
      if (core < to && looks_narrow(drawn, ring, end, to - at_)) {
        if (!move(component, at_, core, cores_)) return false;
      } else if (!move_telling(component, at_, to, limits, sagitta, gaps.of_rings)) {
        return false;
      }
      ring = end;
    }
    for (wavefront::Component& component : cores_)
      if (!move_telling(component, core, to, core_limits, sagitta, gaps.of_cores)) return false;
    arrive(to);
    return gaps.told = true;
  }

  // At the asked tolerance, or finer where rings would meet. @return false if they meet even so
  bool draw(double tolerance, Rings& rings, std::uint32_t& finer) {
    for (int attempt = 0; attempt < 3; ++attempt, tolerance = attempt == 1 ? 0.2 * tolerance : 0) {
      rings.clear();
      drawn_ends_.clear();
      for (const wavefront::Component& component : front_.components) {
        draw_(front_.sources, component, at_, tolerance, rings, tips_ && attempt < 2 ? &*tips_ : nullptr);
        drawn_ends_.push_back(rings.size());
      }
      const Meeting meeting = meeting_(rings);
      finer += attempt > 0;
      touching_ = meeting == Meeting::kContact;
      if (meeting == Meeting::kApart || (attempt == 2 && meeting == Meeting::kContact)) return true;
    }
    return false;
  }

  bool lost_tips() const { return tips_ && tips_->failed(); }
  bool touching() const { return touching_; }  ///< may the rings drawn last have contacts?

 private:
  bool move(wavefront::Component& component, double from, double to, std::vector<wavefront::Component>& out) {
    move_(front_.sources, component, from, to);
    return untangle_(front_.sources, move_.died(), component, to, out);
  }

  bool move_telling(wavefront::Component& component, double from, double to, const GapLimits& limits, double sagitta,
                    Stretches& stretches) {
    lacks_.keep(component, from);
    const std::size_t before = next_.size();
    if (!move(component, from, to, next_)) return false;
    const wavefront::LackLimits near{limits.near, limits.near_corner, limits.slack, 2 * limits.spot_at};
    lacks_.find(front_.sources, std::span(next_).subspan(before), near, sagitta, stretches);
    return true;
  }

  void arrive(double to) {
    std::swap(front_.components, next_);
    at_ = to;
  }

  // A strip 2 w wide has an area of w for each mm of its edge.
  static bool looks_narrow(const Rings& rings, std::size_t begin, std::size_t end, double width) {
    double twice_area = 0, along_axes = 0, edge = 0;
    const auto add_edges = [&](auto add) {
      for (std::size_t r = begin; r < end; ++r) {
        const std::span<const Point> ring = rings[r];
        Vec a = to_vec(ring.back());
        for (const Point p : ring) {
          const Vec b = to_vec(p);
          add(a, b);
          a = b;
        }
      }
    };
    add_edges([&](Vec a, Vec b) {
      twice_area += cross(a, b);
      along_axes += std::abs(b.x - a.x) + std::abs(b.y - a.y);
    });
    // Roots only where it is close: the edge is at most that and at least 1 / sqrt(2) of it.
    if (0.5 * twice_area >= kNarrow * width * along_axes) return false;
    if (0.5 * twice_area < kNarrow * width * 0.7 * along_axes) return true;
    add_edges([&](Vec a, Vec b) { edge += length(b - a); });
    return 0.5 * twice_area < kNarrow * width * edge;
  }

  wavefront::Front front_;
  double at_ = 0;
  bool touching_ = false;
  wavefront::Mover move_;
  wavefront::Untangler untangle_;
  wavefront::Lacks lacks_;
  MeetingCheck meeting_;
  std::vector<wavefront::Component> next_, cores_;
  std::vector<std::size_t> drawn_ends_;  // rings of each component and those before it
  wavefront::Drawer draw_;
  std::optional<ExactTips> tips_;
};

Region thinned_again(const Rings& contours, double mm) {
  PathFilter filter(0, mm * kUnitsPerMm);
  Rings rings;
  for (std::size_t r = 0; r < contours.size(); ++r) filter.append(contours[r], rings);
  return region_of(canonical(rings));
}

// @param odd by how much the distances asked for are more, in units
// @param by_clipper levels that the wavefront cannot tell; else there are none
std::optional<RingLevels> levels_of(const Region& region, const RingPlan& plan, double tolerance_mm, double spot_mm,
                                    const Thinned& thinned, double odd, bool by_clipper) {
  RingLevels result;
  Advance advance(region, thinned);
  bool trusted = true;
  const double tolerance = tolerance_mm * kUnitsPerMm;
  const Rings none;
  for (int level = 0; level < plan.max_rings; ++level) {
    Rings rings;
    LevelGaps gaps;
    if (trusted) {
      const double to = plan.distance_mm(level) * kUnitsPerMm + odd;
      if (spot_mm > 0) {
        const double core = level > 0 ? plan.core_mm(level - 1, spot_mm) * kUnitsPerMm + odd : to;
        trusted = advance.telling(core, to, level > 0 ? result.levels.back() : none,
                                  gap_limits(gap_band(plan, level - 1), spot_mm, tolerance_mm),
                                  gap_limits(core_band(plan, level - 1, spot_mm), spot_mm, tolerance_mm),
                                  std::max(10.0, 0.33 * tolerance), gaps);
      } else {
        trusted = advance(to);
      }
      trusted = trusted && advance.draw(tolerance, rings, result.drawn_finer);
      if (!trusted && !by_clipper) return std::nullopt;
      // An area that comes or goes with the thinning: everything again from contours thinned by less.
      if (advance.lost_tips() && thinned.whole) {
        const double by_mm = kAgain * thinned.by_mm;
        return offset_rings(thinned_again(*thinned.from, by_mm), plan, tolerance_mm, spot_mm, {thinned.from, by_mm, false});
      }
      gaps.told = trusted;
    }
    if (!trusted) {
      rings = clipper_offset(region, plan.distance_mm(level), tolerance_mm);
      ++result.from_clipper;
    }
    if (spot_mm > 0) result.gaps.push_back(std::move(gaps));
    if (rings.empty()) break;
    result.levels.push_back(std::move(rings));
    result.touching.push_back(!trusted || advance.touching());
  }
  return result;
}

}  // namespace

RingLevels offset_rings(const Region& region, const RingPlan& plan, double tolerance_mm, double spot_mm, const Thinned& thinned) {
  for (const double odd : kOdd)
    if (auto levels = levels_of(region, plan, tolerance_mm, spot_mm, thinned, odd, false)) return std::move(*levels);
  return *levels_of(region, plan, tolerance_mm, spot_mm, thinned, kOdd[0], true);
}

Region grow(const Region& region, double outward_mm, double tolerance_mm) {
  if (region.empty()) return {};
  // What lies around the region, bounded far outside: every ring turned, and a frame.
  const double d = outward_mm * kUnitsPerMm + kOdd[0];
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
  Rings rings;
  const auto by_front = [&](double odd) {
    Advance advance(around);
    std::uint32_t finer = 0;
    return advance(outward_mm * kUnitsPerMm + odd) && advance.draw(tolerance_mm * kUnitsPerMm, rings, finer);
  };
  if (std::none_of(std::begin(kOdd), std::end(kOdd), by_front))
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
