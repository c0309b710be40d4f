#include "core/slice/offset/offset_rings.h"

#include <algorithm>
#include <numeric>
#include <optional>
#include <utility>

#include "core/slice/offset/advance.h"
#include "core/geometry/clipper.h"
#include "core/geometry/few_corners.h"
#include "core/geometry/groups.h"
#include "core/geometry/planar.h"
#include "core/geometry/rings.h"

namespace firn::slice {

struct OffsetWork::State {
  Advance advance;
  ExactTips tips;
};

namespace {

// Parallel walls a whole number of units apart would make fronts meet along their lengths; no wall does at
// this distance. Where the front of one distance cannot tell which of its places coincide, that of another
// can.
constexpr double kOdd[] = {0.2973, 1.6131, 3.1429};
constexpr int kAgain = 4;  // times that an area is thinned again before it is not thinned at all

template <class Areas>
Rings rings_of(const Rings& rings, const Areas& areas) {
  Rings out;
  for (const auto& area : areas)
    for (const std::uint32_t ring : area) out.add(rings[ring]);
  return out;
}

using Numbers = std::span<const std::uint32_t>;  // of contours

// @param kept points that stay
Region thinned_again(const Rings& contours, Numbers some, std::span<const char> kept, double mm) {
  FewCorners draw;
  Rings rings;
  std::vector<Vec> line;
  std::vector<std::size_t> stay;
  for (const std::uint32_t ring : some) {
    const std::size_t begin = ring ? contours.ends[ring - 1] : 0;
    line.clear(), stay.clear();
    for (const Point p : contours[ring]) {
      if (kept[begin + line.size()]) stay.push_back(line.size());
      line.push_back(to_vec(p));
    }
    draw(line, mm * kUnitsPerMm, rings, stay);
  }
  return region_of(canonical(rings));
}

BoxOf<std::int32_t> box_of(std::span<const Point> ring) {
  BoxOf<std::int32_t> box;
  for (const Point p : ring) box.add(p.x, p.y);
  return box;
}

// The areas within contours, by what is left of them when they are thinned.
class ContourAreas {
 public:
  explicit ContourAreas(const Rings& contours) : areas_(nested_groups(contours)) {
    for (const std::vector<std::uint32_t>& area : areas_) boxes_.push_back(box_of(contours[area[0]]));
  }
  // The contours of the area whose outer one becomes `ring`. @return none if several may
  Numbers of(std::span<const Point> ring, double thinned) const {
    const BoxOf<std::int32_t> box = box_of(ring);
    const double most = thinned + 2;
    const auto alike = [&](const BoxOf<std::int32_t>& b) {
      return std::abs(double(b.x0) - box.x0) <= most && std::abs(double(b.y0) - box.y0) <= most &&
             std::abs(double(b.x1) - box.x1) <= most && std::abs(double(b.y1) - box.y1) <= most;
    };
    const auto found = std::find_if(boxes_.begin(), boxes_.end(), alike);
    if (found == boxes_.end() || std::any_of(found + 1, boxes_.end(), alike)) return {};
    return areas_[std::size_t(found - boxes_.begin())];
  }

 private:
  std::vector<std::vector<std::uint32_t>> areas_;
  std::vector<BoxOf<std::int32_t>> boxes_;
};

void append(Stretches&& from, Stretches& to) {
  if (to.empty()) return std::swap(from, to);
  to.tips_moved = to.tips_moved || from.tips_moved;
  for (Stretches::Stretch stretch : from.all) {
    stretch.end += std::uint32_t(to.points.size());
    to.all.push_back(stretch);
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
    to.gaps[k].told = to.gaps[k].told && from.gaps[k].told;
    append(std::move(from.gaps[k].of_rings), to.gaps[k].of_rings);
    append(std::move(from.gaps[k].of_cores), to.gaps[k].of_cores);
  }
}

class RingMaker {
 public:
  RingMaker(const RingPlan& plan, double tolerance_mm, double spot_mm, const Thinned& thinned,
            OffsetWork::State& work)
      : plan_(plan),
        tolerance_mm_(tolerance_mm),
        spot_mm_(spot_mm),
        thinned_(thinned),
        advance_(work.advance) {
    if (!thinned.from || thinned.from->empty()) return;
    tips_ = &work.tips;
    tips_->take(*thinned.from);
  }

  RingLevels operator()(const Region& region) {
    std::vector<std::uint32_t> all(thinned_.from ? thinned_.from->size() : 0);
    std::iota(all.begin(), all.end(), 0u);
    return of_region(region, all, 0);
  }

 private:
  // @param contours of the region @param again how many times they have been thinned again; more than kAgain:
  // not thinned
  RingLevels of_region(const Region& region, Numbers contours, int again) {
    const double thinned_mm = again > kAgain ? 0 : thinned_.by_mm;
    const bool asks = thinned_.whole && again <= kAgain;
    const std::vector<std::vector<std::uint32_t>> areas = nested_groups(region);
    // Rings of different areas are too far apart to meet, however they are drawn; or they are all made at
    // once.
    const bool apart = plan_.distance_mm(0) > 2 * (tolerance_mm_ + thinned_mm);
    RingLevels result;
    for (std::size_t a = 0; a < areas.size(); a = apart ? a + 1 : areas.size()) {
      const Advance::Areas some = std::span(areas).subspan(a, apart ? 1 : areas.size());
      if (tips_ && again == 0) tips_->doubts().forget();
      RingLevels made = of_areas(region, some, thinned_mm, asks);
      // An area that may come or go with the thinning: again, from contours that are kept as they are where
      // it may.
      if (asks && tips_ && (tips_->failed() || tips_->doubts().any())) {
        const Numbers its_own =
            apart && areas.size() > 1 ? contours_of(region[areas[a][0]], thinned_mm) : Numbers();
        const Numbers from = its_own.empty() ? contours : its_own;
        const int next = tips_->failed() ? kAgain + 1 : again + 1;
        made = of_region(next > kAgain ? as_they_are(from) : keeping_doubts(from), from, next);
        if (its_own.empty()) return made;
      }
      append(std::move(made), result);
    }
    return result;
  }

  Region as_they_are(Numbers contours) const {
    return region_of(canonical(rings_of(*thinned_.from, std::span(&contours, 1))));
  }

  Region keeping_doubts(Numbers contours) {
    tips_->doubts().keep();
    return thinned_again(*thinned_.from, contours, tips_->kept(), thinned_.by_mm);
  }

  Numbers contours_of(std::span<const Point> ring, double thinned_mm) {
    if (!contours_) contours_.emplace(*thinned_.from);
    return contours_->of(ring, thinned_mm * kUnitsPerMm);
  }

  // @param asks whether doubts are listed
  RingLevels of_areas(const Region& region, Advance::Areas areas, double thinned_mm, bool asks) {
    RingLevels made;
    for (const double odd : kOdd) {
      made = {};
      if (tips_) tips_->begin(thinned_mm * kUnitsPerMm, asks);
      if (by_front(region, areas, odd, thinned_mm, made)) return made;
    }
    by_clipper(rings_of(region, areas), made);
    return made;
  }

  // @return false if the wavefront could not tell: then the levels before are made
  bool by_front(const Region& region, Advance::Areas areas, double odd, double thinned_mm, RingLevels& made) {
    const double tolerance = tolerance_mm_ * kUnitsPerMm;
    const Rings none;
    advance_.begin(region, areas, tips_ ? thinned_mm * kUnitsPerMm : 0);
    for (int level = 0; level < plan_.max_rings; ++level) {
      const double to = plan_.distance_mm(level) * kUnitsPerMm + odd;
      if (spot_mm_ > 0) {
        const double core = level > 0 ? plan_.core_mm(level - 1, spot_mm_) * kUnitsPerMm + odd : to;
        made.gaps.emplace_back();
        if (!advance_.telling(core, to, level > 0 ? made.levels.back() : none,
                              gap_limits(gap_band(plan_, level - 1), spot_mm_, tolerance_mm_),
                              gap_limits(core_band(plan_, level - 1, spot_mm_), spot_mm_, tolerance_mm_),
                              std::max(10.0, 0.33 * tolerance), made.gaps.back()))
          return false;
        LevelGaps& gaps = made.gaps.back();
        gaps.told = true, gaps.of_rings.tips_moved = gaps.of_cores.tips_moved = tips_ != nullptr;
      } else if (!advance_(to)) {
        return false;
      }
      Rings rings;
      if (!advance_.draw(tolerance, tips_, rings, made.drawn_finer)) return false;
      if (spot_mm_ > 0 && rings.size() < advance_.loops()) {
        made.gaps.back().of_rings.forget_corners();
        made.gaps.back().of_cores.forget_corners();
      }
      if (rings.empty() || (tips_ && tips_->failed())) break;
      made.levels.push_back(std::move(rings));
      made.touching.push_back(advance_.touching());
    }
    return true;
  }

  // The levels that are not made.
  void by_clipper(const Region& region, RingLevels& made) {
    made.gaps.resize(std::min(made.gaps.size(), made.levels.size()));
    for (int level = int(made.levels.size()); level < plan_.max_rings; ++level) {
      Rings rings = clipper_offset(region, plan_.distance_mm(level), tolerance_mm_);
      ++made.from_clipper;
      if (spot_mm_ > 0) made.gaps.emplace_back();
      if (rings.empty()) break;
      made.levels.push_back(std::move(rings));
      made.touching.push_back(true);
    }
  }

  const RingPlan& plan_;
  double tolerance_mm_, spot_mm_;
  const Thinned& thinned_;
  ExactTips* tips_ = nullptr;
  std::optional<ContourAreas> contours_;
  Advance& advance_;
};

}  // namespace

OffsetWork::OffsetWork() : state_(std::make_unique<State>()) {}
OffsetWork::~OffsetWork() = default;
OffsetWork::OffsetWork(OffsetWork&&) noexcept = default;
OffsetWork& OffsetWork::operator=(OffsetWork&&) noexcept = default;

RingLevels offset_rings(const Region& region, const RingPlan& plan, double tolerance_mm, double spot_mm,
                        const Thinned& thinned, OffsetWork& work) {
  return RingMaker(plan, tolerance_mm, spot_mm, thinned, work.state())(region);
}

RingLevels offset_rings(const Region& region, const RingPlan& plan, double tolerance_mm, double spot_mm,
                        const Thinned& thinned) {
  OffsetWork work;
  return offset_rings(region, plan, tolerance_mm, spot_mm, thinned, work);
}

Region grow(const Region& region, double outward_mm, double tolerance_mm) {
  if (region.empty()) return {};
  // What lies around the region, bounded far outside: every ring turned, and a frame.
  const double d = outward_mm * kUnitsPerMm + kOdd[0];
  BoxOf<std::int32_t> box;
  for (const Point p : region.points) box.add(p.x, p.y);
  const std::int32_t far = std::int32_t(3 * d) + 10 * kUnitsPerMm;
  Region around;
  const Point frame[] = {{box.x0 - far, box.y0 - far},
                         {box.x1 + far, box.y0 - far},
                         {box.x1 + far, box.y1 + far},
                         {box.x0 - far, box.y1 + far}};
  around.add(frame);
  std::vector<Point> ring;
  for (std::size_t r = 0; r < region.size(); ++r) {
    ring.assign(region[r].rbegin(), region[r].rend());
    around.add(ring);
  }
  Rings rings;
  Advance advance;
  const std::vector<std::vector<std::uint32_t>> areas = nested_groups(around);
  const auto by_front = [&](double odd) {
    std::uint32_t finer = 0;
    advance.begin(around, areas);
    return advance(outward_mm * kUnitsPerMm + odd) &&
           advance.draw(tolerance_mm * kUnitsPerMm, nullptr, rings, finer);
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
