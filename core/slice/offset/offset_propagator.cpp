#include "core/slice/offset/offset_propagator.h"

#include <algorithm>
#include <utility>

#include "core/slice/offset/topology_check.h"

namespace firn::slice {
namespace {

constexpr double kNarrow = 4.0;   // half the width of narrow strips over the distance to the next level
constexpr std::size_t kFew = 64;  // edges: small components often vanish, large ones seldom

// Returns whether a component vanishes because no disc of that radius fits into its box. Arcs bulge into it.
bool vanishes(const wavefront::Component& component, double way) {
  if (component.edges.size() > kFew) return false;
  geometry::BoxOf<double> box;
  for (const wavefront::WavefrontEdge& edge : component.edges) box.add(edge.from.x, edge.from.y);
  return std::min(box.x1 - box.x0, box.y1 - box.y0) < 2 * way;
}

}  // namespace

void OffsetPropagator::begin(const geometry::Region& region, Areas areas, double simplified) {
  simplified_ = simplified;
  sites_.clear();
  here_.clear();
  for (const std::vector<std::uint32_t>& area : areas) wavefront::wavefront_of(region, area, sites_, here_);
  at_ = 0;
  trim_.begin(sites_);
}

bool OffsetPropagator::operator()(double to) {
  next_.clear();
  propagate_.list_peaks(to - simplified_);
  for (wavefront::Component& component : here_.all())
    if (!move(component, at_, to, next_)) return false;
  arrive(to);
  return true;
}

bool OffsetPropagator::advance_with_gaps(double core, double to, const geometry::Rings& drawn,
                                         const GapLimits& limits, const GapLimits& core_limits,
                                         double sagitta, LevelGaps& gaps) {
  next_.clear();
  eroded_cores_.clear();
  propagate_.list_peaks(to - simplified_);
  for (std::size_t c = 0, ring = 0; c < here_.size(); ++c) {
    wavefront::Component& component = here_.all()[c];
    const std::size_t end = core < to ? drawn_ends_[c] : 0;
    if (core < to && looks_narrow(drawn, ring, end, to - at_)) {
      if (!move(component, at_, core, eroded_cores_)) return false;
    } else if (!move_with_gaps(component, at_, to, limits, sagitta, gaps.of_rings)) {
      return false;
    }
    ring = end;
  }
  for (wavefront::Component& component : eroded_cores_.all())
    if (!move_with_gaps(component, core, to, core_limits, sagitta, gaps.of_eroded_cores)) return false;
  arrive(to);
  return true;
}

bool OffsetPropagator::draw(double tolerance, CuspCorrector* cusps, geometry::Rings& rings,
                            std::uint32_t& finer) {
  for (int attempt = 0; attempt < 3; ++attempt, tolerance = attempt == 1 ? 0.2 * tolerance : 0) {
    if (attempt == 2 && cusps && cusps->lists_uncertain()) mark_uncertain_contact(rings, *cusps);
    rings.clear();
    drawn_ends_.clear();
    for (const wavefront::Component& component : here_.all()) {
      draw_(sites_, component, at_, tolerance, rings, attempt < 2 ? cusps : nullptr);
      drawn_ends_.push_back(rings.size());
    }
    const double facing = cusps && cusps->lists_uncertain() ? 2 * (cusps->simplified() + tolerance) : 0;
    const geometry::Intersection intersection = intersection_check_(rings, facing);
    if (facing > 0 && intersection == geometry::Intersection::kDisjoint)
      check_topology(rings, intersection_check_, facing, propagate_.peaks(), at_, *cusps);
    finer += attempt > 0;
    touching_ = intersection == geometry::Intersection::kTouching;
    if (intersection == geometry::Intersection::kDisjoint ||
        (attempt == 2 && intersection == geometry::Intersection::kTouching))
      return true;
  }
  return false;
}

// Where rings with corrected cusps intersect, sides may have been closer than the simplification.
void OffsetPropagator::mark_uncertain_contact(const geometry::Rings& rings, CuspCorrector& cusps) const {
  const geometry::Vec one = to_vec(rings.points[intersection_check_.met()]),
                      other = to_vec(rings.points[intersection_check_.next(intersection_check_.met())]);
  const geometry::Vec place = 0.5 * (one + other);
  if (cusps.uncertain().resolved(place, at_))
    cusps.fail();
  else
    cusps.uncertain().add(place, at_);
}

std::size_t OffsetPropagator::loops() {
  std::size_t loops = 0;
  for (const wavefront::Component& component : here_.all()) loops += component.ends.size();
  return loops;
}

bool OffsetPropagator::move(wavefront::Component& component, double from, double to,
                            wavefront::Components& out) {
  if (vanishes(component, to - from - simplified_)) return true;
  propagate_(sites_, component, from, to);
  return trim_(component, to, out);
}

bool OffsetPropagator::move_with_gaps(wavefront::Component& component, double from, double to,
                                      const GapLimits& limits, double sagitta,
                                      geometry::BoundaryChains& chains) {
  gap_detector_.keep(component, from);
  const std::size_t before = next_.size();
  if (!move(component, from, to, next_)) return false;
  const wavefront::CoverageGapLimits near{limits.near, limits.far, limits.near_corner, limits.slack,
                                          2 * limits.void_at};
  gap_detector_.find(sites_, next_.all().subspan(before), near, sagitta, chains);
  return true;
}

void OffsetPropagator::arrive(double to) {
  std::swap(here_, next_);
  at_ = to;
}

// A strip 2 w wide has an area of w for each mm of its edge.
bool OffsetPropagator::looks_narrow(const geometry::Rings& rings, std::size_t begin, std::size_t end,
                                    double width) {
  double twice_area = 0, along_axes = 0, edge = 0;
  const auto add_edges = [&](auto add) {
    for (std::size_t r = begin; r < end; ++r) {
      const std::span<const geometry::Point> ring = rings[r];
      geometry::Vec a = to_vec(ring.back());
      for (const geometry::Point p : ring) {
        const geometry::Vec b = to_vec(p);
        add(a, b);
        a = b;
      }
    }
  };
  add_edges([&](geometry::Vec a, geometry::Vec b) {
    twice_area += cross(a, b);
    along_axes += std::abs(b.x - a.x) + std::abs(b.y - a.y);
  });
  // Computes roots only in close cases: the edge length is at most `along_axes` and at least 1 / sqrt(2) of
  // it.
  if (0.5 * twice_area >= kNarrow * width * along_axes) return false;
  if (0.5 * twice_area < kNarrow * width * 0.7 * along_axes) return true;
  add_edges([&](geometry::Vec a, geometry::Vec b) { edge += length(b - a); });
  return 0.5 * twice_area < kNarrow * width * edge;
}

}  // namespace firn::slice
