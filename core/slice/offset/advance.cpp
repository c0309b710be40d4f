#include "core/slice/offset/advance.h"

#include <algorithm>
#include <utility>

#include "core/slice/offset/doubtful_areas.h"

namespace firn::slice {
namespace {

constexpr double kNarrow = 4.0;   // of the way to the next level: half the width of strips that look narrow
constexpr std::size_t kFew = 64;  // pieces: many small components vanish, few large ones

// Does it vanish on the way, because no disc of that radius fits into its box? Arcs bulge into it.
bool vanishes(const wavefront::Component& component, double way) {
  if (component.pieces.size() > kFew) return false;
  BoxOf<double> box;
  for (const wavefront::Piece& piece : component.pieces) box.add(piece.from.x, piece.from.y);
  return std::min(box.x1 - box.x0, box.y1 - box.y0) < 2 * way;
}

}  // namespace

void Advance::begin(const Region& region, Areas areas, double thinned) {
  thinned_ = thinned;
  sources_.clear();
  here_.clear();
  for (const std::vector<std::uint32_t>& area : areas) wavefront::front_of(region, area, sources_, here_);
  at_ = 0;
  untangle_.begin(sources_);
}

bool Advance::operator()(double to) {
  next_.clear();
  move_.list_peaks(to - thinned_);
  for (wavefront::Component& component : here_.all())
    if (!move(component, at_, to, next_)) return false;
  arrive(to);
  return true;
}

bool Advance::telling(double core, double to, const Rings& drawn, const GapLimits& limits,
                      const GapLimits& core_limits, double sagitta, LevelGaps& gaps) {
  next_.clear(), cores_.clear();
  move_.list_peaks(to - thinned_);
  for (std::size_t c = 0, ring = 0; c < here_.size(); ++c) {
    wavefront::Component& component = here_.all()[c];
    const std::size_t end = core < to ? drawn_ends_[c] : 0;
    if (core < to && looks_narrow(drawn, ring, end, to - at_)) {
      if (!move(component, at_, core, cores_)) return false;
    } else if (!move_telling(component, at_, to, limits, sagitta, gaps.of_rings)) {
      return false;
    }
    ring = end;
  }
  for (wavefront::Component& component : cores_.all())
    if (!move_telling(component, core, to, core_limits, sagitta, gaps.of_cores)) return false;
  arrive(to);
  return true;
}

bool Advance::draw(double tolerance, ExactTips* tips, Rings& rings, std::uint32_t& finer) {
  for (int attempt = 0; attempt < 3; ++attempt, tolerance = attempt == 1 ? 0.2 * tolerance : 0) {
    if (attempt == 2 && tips && tips->asks()) doubt_meeting(rings, *tips);
    rings.clear();
    drawn_ends_.clear();
    for (const wavefront::Component& component : here_.all()) {
      draw_(sources_, component, at_, tolerance, rings, attempt < 2 ? tips : nullptr);
      drawn_ends_.push_back(rings.size());
    }
    const double facing = tips && tips->asks() ? 2 * (tips->thinned() + tolerance) : 0;
    const Meeting meeting = meeting_(rings, facing);
    if (facing > 0 && meeting == Meeting::kApart)
      doubt_areas(rings, meeting_, facing, move_.peaks(), at_, *tips);
    finer += attempt > 0;
    touching_ = meeting == Meeting::kContact;
    if (meeting == Meeting::kApart || (attempt == 2 && meeting == Meeting::kContact)) return true;
  }
  return false;
}

// Where rings meet with their tips in exact places, walls may have been closer than the thinning.
void Advance::doubt_meeting(const Rings& rings, ExactTips& tips) const {
  const Vec one = to_vec(rings.points[meeting_.met()]),
            other = to_vec(rings.points[meeting_.next(meeting_.met())]);
  const Vec place = 0.5 * (one + other);
  if (tips.doubts().settled(place, at_))
    tips.fail();
  else
    tips.doubts().add(place, at_);
}

std::size_t Advance::loops() {
  std::size_t loops = 0;
  for (const wavefront::Component& component : here_.all()) loops += component.ends.size();
  return loops;
}

bool Advance::move(wavefront::Component& component, double from, double to, wavefront::Components& out) {
  if (vanishes(component, to - from - thinned_)) return true;
  move_(sources_, component, from, to);
  return untangle_(component, to, out);
}

bool Advance::move_telling(wavefront::Component& component, double from, double to, const GapLimits& limits,
                           double sagitta, Stretches& stretches) {
  lacks_.keep(component, from);
  const std::size_t before = next_.size();
  if (!move(component, from, to, next_)) return false;
  const wavefront::LackLimits near{limits.near, limits.far, limits.near_corner, limits.slack,
                                   2 * limits.spot_at};
  lacks_.find(sources_, next_.all().subspan(before), near, sagitta, stretches);
  return true;
}

void Advance::arrive(double to) {
  std::swap(here_, next_);
  at_ = to;
}

// A strip 2 w wide has an area of w for each mm of its edge.
bool Advance::looks_narrow(const Rings& rings, std::size_t begin, std::size_t end, double width) {
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

}  // namespace firn::slice
