#include "core/slice/offset/offset_rings.h"

#include <algorithm>
#include <numeric>
#include <optional>
#include <utility>

#include "core/geometry/clipper.h"
#include "core/geometry/groups.h"
#include "core/geometry/minimum_link.h"
#include "core/geometry/planar.h"
#include "core/geometry/point_measures.h"
#include "core/geometry/rings.h"
#include "core/slice/offset/offset_propagator.h"

namespace firn::slice {

struct OffsetWork::State {
  OffsetPropagator propagator;
  CuspCorrector cusps;
};

namespace {

// With parallel sides at integer distances, wavefronts would meet along whole edges; no two sides have this
// distance. Where the wavefront at one distance is ambiguous because points coincide, that at another one is
// not.
constexpr double kOdd[] = {0.2973, 1.6131, 3.1429};
constexpr int kAgain =
    4;  // number of repeated simplifications of an area before it is used without simplification

template <class Areas>
geometry::Rings rings_of(const geometry::Rings& rings, const Areas& areas) {
  geometry::Rings out;
  for (const auto& area : areas)
    for (const std::uint32_t ring : area) out.add(rings[ring]);
  return out;
}

using Numbers = std::span<const std::uint32_t>;  // of contours

// @param kept points that must remain
geometry::Region simplified_again(const geometry::Rings& contours, Numbers some, std::span<const char> kept,
                                  double mm) {
  geometry::MinimumLinkSimplifier draw;
  geometry::Rings rings;
  std::vector<geometry::Vec> line;
  std::vector<std::size_t> stay;
  for (const std::uint32_t ring : some) {
    const std::size_t begin = ring ? contours.ends[ring - 1] : 0;
    line.clear();
    stay.clear();
    for (const geometry::Point p : contours[ring]) {
      if (kept[begin + line.size()]) stay.push_back(line.size());
      line.push_back(to_vec(p));
    }
    draw(line, mm * geometry::kUnitsPerMm, rings, stay);
  }
  return region_of(canonical(rings));
}

// ContourAreas finds the contours of the areas of a simplified region.
class ContourAreas {
 public:
  explicit ContourAreas(const geometry::Rings& contours) : areas_(nested_groups(contours)) {
    for (const std::vector<std::uint32_t>& area : areas_) boxes_.push_back(box_of(contours[area[0]]));
  }
  // Returns the contours of the area whose outer ring becomes `ring`; nothing if there are several
  // candidates.
  Numbers of(std::span<const geometry::Point> ring, double simplified) const {
    const geometry::BoxOf<std::int32_t> box = box_of(ring);
    const double most = simplified + 2;
    const auto alike = [&](const geometry::BoxOf<std::int32_t>& b) {
      return std::abs(double(b.x0) - box.x0) <= most && std::abs(double(b.y0) - box.y0) <= most &&
             std::abs(double(b.x1) - box.x1) <= most && std::abs(double(b.y1) - box.y1) <= most;
    };
    const auto found = std::find_if(boxes_.begin(), boxes_.end(), alike);
    if (found == boxes_.end() || std::any_of(found + 1, boxes_.end(), alike)) return {};
    return areas_[std::size_t(found - boxes_.begin())];
  }

 private:
  std::vector<std::vector<std::uint32_t>> areas_;
  std::vector<geometry::BoxOf<std::int32_t>> boxes_;
};

void append(geometry::BoundaryChains&& from, geometry::BoundaryChains& to) {
  if (to.empty()) return std::swap(from, to);
  to.cusps_moved = to.cusps_moved || from.cusps_moved;
  for (geometry::BoundaryChains::Chain chain : from.all) {
    chain.end += std::uint32_t(to.points.size());
    to.all.push_back(chain);
  }
  to.points.insert(to.points.end(), from.points.begin(), from.points.end());
}

void append(RingLevels&& from, RingLevels& to) {
  to.from_clipper += from.from_clipper;
  to.drawn_finer += from.drawn_finer;
  if (to.levels.size() < from.levels.size()) to.levels.resize(from.levels.size());
  if (to.gaps.size() < from.gaps.size()) to.gaps.resize(from.gaps.size(), LevelGaps{true, {}, {}});
  to.touching.resize(to.levels.size());
  for (std::size_t k = 0; k < from.levels.size(); ++k) {
    if (to.levels[k].empty())
      std::swap(to.levels[k], from.levels[k]);
    else
      for (std::size_t r = 0; r < from.levels[k].size(); ++r) to.levels[k].add(from.levels[k][r]);
    to.touching[k] = to.touching[k] || from.touching[k];
  }
  for (std::size_t k = 0; k < from.gaps.size(); ++k) {
    to.gaps[k].known = to.gaps[k].known && from.gaps[k].known;
    append(std::move(from.gaps[k].of_rings), to.gaps[k].of_rings);
    append(std::move(from.gaps[k].of_eroded_cores), to.gaps[k].of_eroded_cores);
  }
}

class RingMaker {
 public:
  RingMaker(const RingPlan& plan, double tolerance_mm, double void_mm, const Simplified& simplified,
            OffsetWork::State& work)
      : plan_(plan),
        tolerance_mm_(tolerance_mm),
        void_mm_(void_mm),
        simplified_(simplified),
        propagator_(work.propagator) {
    if (!simplified.from || simplified.from->empty()) return;
    cusps_ = &work.cusps;
    cusps_->take(*simplified.from);
  }

  RingLevels operator()(const geometry::Region& region) {
    std::vector<std::uint32_t> all(simplified_.from ? simplified_.from->size() : 0);
    std::iota(all.begin(), all.end(), 0u);
    return of_region(region, all, 0);
  }

 private:
  // @param contours of the region
  // @param again number of repeated simplifications; above kAgain: without simplification
  RingLevels of_region(const geometry::Region& region, Numbers contours, int again) {
    const double simplified_mm = again > kAgain ? 0 : simplified_.by_mm;
    const bool lists_uncertain = simplified_.whole && again <= kAgain;
    const std::vector<std::vector<std::uint32_t>> areas = nested_groups(region);
    // Rings of different areas are too far apart to intersect at any tolerance; otherwise all areas are
    // computed together.
    const bool apart = plan_.distance_mm(0) > 2 * (tolerance_mm_ + simplified_mm);
    RingLevels result;
    for (std::size_t a = 0; a < areas.size(); a = apart ? a + 1 : areas.size()) {
      const OffsetPropagator::Areas some = std::span(areas).subspan(a, apart ? 1 : areas.size());
      if (cusps_ && again == 0) cusps_->uncertain().forget();
      RingLevels made = of_areas(region, some, simplified_mm, lists_uncertain);
      // An area that may appear or vanish with the simplification is computed again from contours that are
      // not simplified at the uncertain places.
      if (lists_uncertain && cusps_ && (cusps_->failed() || cusps_->uncertain().any())) {
        const Numbers its_own =
            apart && areas.size() > 1 ? contours_of(region[areas[a][0]], simplified_mm) : Numbers();
        const Numbers from = its_own.empty() ? contours : its_own;
        const int next = cusps_->failed() ? kAgain + 1 : again + 1;
        made = of_region(next > kAgain ? as_they_are(from) : refined(from), from, next);
        if (its_own.empty()) return made;
      }
      append(std::move(made), result);
    }
    return result;
  }

  geometry::Region as_they_are(Numbers contours) const {
    return region_of(canonical(rings_of(*simplified_.from, std::span(&contours, 1))));
  }

  geometry::Region refined(Numbers contours) {
    cusps_->uncertain().refine();
    return simplified_again(*simplified_.from, contours, cusps_->kept(), simplified_.by_mm);
  }

  Numbers contours_of(std::span<const geometry::Point> ring, double simplified_mm) {
    if (!contours_) contours_.emplace(*simplified_.from);
    return contours_->of(ring, simplified_mm * geometry::kUnitsPerMm);
  }

  // @param lists_uncertain whether uncertain places are listed
  RingLevels of_areas(const geometry::Region& region, OffsetPropagator::Areas areas, double simplified_mm,
                      bool lists_uncertain) {
    RingLevels made;
    for (const double odd : kOdd) {
      made = {};
      if (cusps_) cusps_->begin(simplified_mm * geometry::kUnitsPerMm, lists_uncertain);
      if (by_front(region, areas, odd, simplified_mm, made)) return made;
    }
    by_clipper(rings_of(region, areas), made);
    return made;
  }

  // @return false if the wavefront is ambiguous; the levels before that are complete
  bool by_front(const geometry::Region& region, OffsetPropagator::Areas areas, double odd,
                double simplified_mm, RingLevels& made) {
    const double tolerance = tolerance_mm_ * geometry::kUnitsPerMm;
    const geometry::Rings none;
    propagator_.begin(region, areas, cusps_ ? simplified_mm * geometry::kUnitsPerMm : 0);
    for (int level = 0; level < plan_.max_rings; ++level) {
      const double to = plan_.distance_mm(level) * geometry::kUnitsPerMm + odd;
      if (void_mm_ > 0) {
        const double core =
            level > 0 ? plan_.eroded_core_mm(level - 1, void_mm_) * geometry::kUnitsPerMm + odd : to;
        made.gaps.emplace_back();
        if (!propagator_.advance_with_gaps(
                core, to, level > 0 ? made.levels.back() : none,
                gap_limits(gap_band(plan_, level - 1), void_mm_, tolerance_mm_),
                gap_limits(eroded_core_band(plan_, level - 1, void_mm_), void_mm_, tolerance_mm_),
                std::max(10.0, 0.33 * tolerance), made.gaps.back()))
          return false;
        LevelGaps& gaps = made.gaps.back();
        gaps.known = true;
        gaps.of_rings.cusps_moved = gaps.of_eroded_cores.cusps_moved = cusps_ != nullptr;
      } else if (!propagator_(to)) {
        return false;
      }
      geometry::Rings rings;
      if (!propagator_.draw(tolerance, cusps_, rings, made.drawn_finer)) return false;
      if (void_mm_ > 0 && rings.size() < propagator_.loops()) {
        made.gaps.back().of_rings.forget_corners();
        made.gaps.back().of_eroded_cores.forget_corners();
      }
      if (rings.empty() || (cusps_ && cusps_->failed())) break;
      made.levels.push_back(std::move(rings));
      made.touching.push_back(propagator_.touching());
    }
    return true;
  }

  // Computes the missing levels.
  void by_clipper(const geometry::Region& region, RingLevels& made) {
    made.gaps.resize(std::min(made.gaps.size(), made.levels.size()));
    for (int level = int(made.levels.size()); level < plan_.max_rings; ++level) {
      geometry::Rings rings = clipper_offset(region, plan_.distance_mm(level), tolerance_mm_);
      ++made.from_clipper;
      if (void_mm_ > 0) made.gaps.emplace_back();
      if (rings.empty()) break;
      made.levels.push_back(std::move(rings));
      made.touching.push_back(true);
    }
  }

  const RingPlan& plan_;
  double tolerance_mm_, void_mm_;
  const Simplified& simplified_;
  CuspCorrector* cusps_ = nullptr;
  std::optional<ContourAreas> contours_;
  OffsetPropagator& propagator_;
};

}  // namespace

OffsetWork::OffsetWork() : state_(std::make_unique<State>()) {}
OffsetWork::~OffsetWork() = default;
OffsetWork::OffsetWork(OffsetWork&&) noexcept = default;
OffsetWork& OffsetWork::operator=(OffsetWork&&) noexcept = default;

RingLevels offset_rings(const geometry::Region& region, const RingPlan& plan, double tolerance_mm,
                        double void_mm, const Simplified& simplified, OffsetWork& work) {
  return RingMaker(plan, tolerance_mm, void_mm, simplified, work.state())(region);
}

RingLevels offset_rings(const geometry::Region& region, const RingPlan& plan, double tolerance_mm,
                        double void_mm, const Simplified& simplified) {
  OffsetWork work;
  return offset_rings(region, plan, tolerance_mm, void_mm, simplified, work);
}

geometry::Region grow(const geometry::Region& region, double outward_mm, double tolerance_mm) {
  if (region.empty()) return {};
  // The surroundings of the region: every ring reversed, inside a distant frame.
  const double d = outward_mm * geometry::kUnitsPerMm + kOdd[0];
  geometry::BoxOf<std::int32_t> box;
  for (const geometry::Point p : region.points) box.add(p.x, p.y);
  const std::int32_t far = std::int32_t(3 * d) + 10 * geometry::kUnitsPerMm;
  geometry::Region around;
  const geometry::Point frame[] = {{box.x0 - far, box.y0 - far},
                                   {box.x1 + far, box.y0 - far},
                                   {box.x1 + far, box.y1 + far},
                                   {box.x0 - far, box.y1 + far}};
  around.add(frame);
  std::vector<geometry::Point> ring;
  for (std::size_t r = 0; r < region.size(); ++r) {
    ring.assign(region[r].rbegin(), region[r].rend());
    around.add(ring);
  }
  geometry::Rings rings;
  OffsetPropagator propagator;
  const std::vector<std::vector<std::uint32_t>> areas = nested_groups(around);
  const auto by_front = [&](double odd) {
    std::uint32_t finer = 0;
    propagator.begin(around, areas);
    return propagator(outward_mm * geometry::kUnitsPerMm + odd) &&
           propagator.draw(tolerance_mm * geometry::kUnitsPerMm, nullptr, rings, finer);
  };
  if (std::none_of(std::begin(kOdd), std::end(kOdd), by_front))
    return clipper_offset(region, -outward_mm, tolerance_mm);
  // Reverses the rings again, without the frame, which is the ring that extends furthest.
  geometry::Region grown;
  const std::int32_t frame_x = box.x0 - std::int32_t(1.5 * d) - 5 * geometry::kUnitsPerMm;
  for (std::size_t r = 0; r < rings.size(); ++r) {
    if (rings[r][0].x < frame_x || rings[r][1].x < frame_x) continue;
    ring.assign(rings[r].rbegin(), rings[r].rend());
    grown.add(ring);
  }
  return grown;
}

}  // namespace firn::slice
