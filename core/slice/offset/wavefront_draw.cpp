#include <algorithm>

#include "core/geometry/lanes.h"
#include "core/geometry/simplify_ring.h"
#include "core/slice/offset/wavefront.h"

namespace firn::slice::wavefront {
namespace {

constexpr double kStraight = 0.02;  // sine of a bend below which a corner is straight
// Width of an area below which its cusps are examined, in distances within which bends are one cusp.
constexpr double kThin = 2;
constexpr double kFar =
    1.5;  // simplifications: cusps that move by less are at most 0.05 mm too near to a third side
constexpr int kDeepest = 12;  // an arc becomes 4096 chords at most

// Returns whether a wavefront turns left, or back, from one direction to another. Its right turns are arcs.
bool turns_by(geometry::Vec from, geometry::Vec to, double cosine, double sine = 0) {
  const double ahead = dot(from, to);
  return ahead < 0 || (ahead <= cosine && cross(from, to) > sine);
}

// Draws the points strictly between a and b (directions from the centre, of length d). They lie outside the
// arc by two thirds of the sagitta of their chords, which so run as far inside the arc as outside; the first
// and the last chord run too far inside by two thirds as well. All halves of a level are congruent, so that
// one root serves a level.
class Arcs {
 public:
  Arcs(double d, double within, std::vector<geometry::Vec>& line)
      : line_(line), d_(d), coarse_(square_at(within)), enough_(square_at(1.5 * within)) {}

  void add(geometry::Vec centre, geometry::Vec a, geometry::Vec b) {
    double square = dot(a + b, a + b);
    if (square >= coarse_ || square <= 0) return;
    int levels = 0;
    do {
      const double l = std::sqrt(square);
      factor_[levels] = d_ / l;
      square = 2 * d_ * (d_ + 0.5 * l);  // for the halves: cos^2 of half the angle
    } while (++levels < kDeepest && square < enough_ && square > 0);
    outside_ = 1 + 2.0 / 3.0 * (1 - 0.5 * std::sqrt(square) / d_);
    centre_ = centre;
    halve(a, b, 0, levels);
  }

 private:
  // The middle of a chord lies |a + b| / 2 from the centre.
  double square_at(double bulge) const { return bulge < d_ ? 4 * (d_ - bulge) * (d_ - bulge) : 0.0; }

  void halve(geometry::Vec a, geometry::Vec b, int level, int levels) {
    const geometry::Vec middle = factor_[level] * (a + b);
    if (level + 1 < levels) halve(a, middle, level + 1, levels);
    line_.push_back(centre_ + outside_ * middle);
    if (level + 1 < levels) halve(middle, b, level + 1, levels);
  }

  std::vector<geometry::Vec>& line_;
  double d_, coarse_, enough_;
  double outside_ = 1;
  geometry::Vec centre_;
  double factor_[kDeepest] = {};
};

}  // namespace

void Drawer::operator()(std::span<const Site> sites, const Component& component, double d, double tolerance,
                        geometry::Rings& rings, CuspCorrector* cusps) {
  // One fifth of the tolerance is used by chords of arcs, the rest by the simplification; never finer than 1
  // um.
  const double within = std::max(10.0, 0.2 * tolerance), simplification = 0.8 * tolerance;
  const double near = cusps ? cusps->near() * cusps->near() : 0, inverse = 1 / d;
  Arcs arcs(d, within, line_);
  std::size_t begin = 0;
  for (const std::uint32_t end : component.ends) {
    const std::span<const WavefrontEdge> loop = std::span(component.edges).subspan(begin, end - begin);
    begin = end;
    line_.clear();
    cusps_.clear();
    if (cusps) places_.resize(loop.size());
    Bends bends;
    geometry::Vec at = loop[0].from;
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const Site& site = sites[std::size_t(loop[i].site)];
      if (cusps) {
        places_[i] = std::uint32_t(line_.size());
        if (i == 0 || dot(at - bends.last, at - bends.last) > near) {
          const Site& before = sites[std::size_t(loop[i > 0 ? i - 1 : loop.size() - 1].site)];
          bends = {i, before.corner() ? inverse * right_of(at - before.at) : before.along, at, false};
        }
        bends.last = at;
        const geometry::Vec along = site.corner() ? inverse * right_of(at - site.at) : site.along;
        if (bends.sharp) {
          cusp_at(sites, loop, bends.first, i, d, *cusps);
        } else if (turns_by(bends.from, along, CuspCorrector::kCusp)) {
          bends.sharp = true;
          for (std::size_t k = bends.first; k <= i; ++k) cusp_at(sites, loop, bends.first, k, d, *cusps);
        }
      }
      line_.push_back(at);
      const geometry::Vec to = loop[i + 1 < loop.size() ? i + 1 : 0].from;
      if (site.corner()) arcs.add(site.at, at - site.at, to - site.at);
      at = to;
    }
    if (!cusps_.empty()) {
      if (!move_cusps()) continue;
      if (cusps->lists_uncertain()) list_third_sides(*cusps, d);
    }
    simplify_ring(line_, simplification, rings);
  }
}

// Corrects the cusp at the start of an edge. @param first first edge of the group of bends
void Drawer::cusp_at(std::span<const Site> sites, std::span<const WavefrontEdge> loop, std::size_t first,
                     std::size_t edge, double d, CuspCorrector& cusps) {
  const geometry::Vec at = loop[edge].from;
  const auto side = [&](std::size_t p) -> CuspCorrector::Side {
    const Site& s = sites[std::size_t(loop[p].site)];
    if (!s.corner()) return {at - d * left_of(s.along), s.along};
    return {s.at, (1 / d) * right_of(at - s.at)};
  };
  const CuspCorrector::Side before = side(edge > 0 ? edge - 1 : loop.size() - 1), after = side(edge);
  if (!turns_by(before.along, after.along, 1, kStraight)) return;
  geometry::Vec to = at;
  if (!cusps.move(to, before, after, d)) return;
  cusps_.push_back(
      {places_[edge], at, to, right_of(before.along) + right_of(after.along), before, std::uint32_t(edge)});
  for (std::size_t last = cusps_.size() - 1; last > 0; --last) {
    const Cusp &one = cusps_[last - 1], &other = cusps_[last];
    if (one.edge < first || dot(other.to - one.to, other.before.along) >= 0) return;
    // The two have passed each other: the part between them has vanished.
    to = 0.5 * (one.from + at);
    if (!cusps.move(to, one.before, after, d)) return;
    for (std::size_t k = last - 1; k < cusps_.size(); ++k) cusps_[k].to = to;
  }
}

// Cusps may be nearer to a third side than to their own two.
void Drawer::list_third_sides(CuspCorrector& cusps, double d) const {
  const double far = looks_narrow_on_average(kThin * cusps.near()) ? 0 : kFar * cusps.simplified();
  for (const Cusp& cusp : cusps_)
    if (const geometry::Vec way = cusp.to - cusp.from;
        dot(way, way) >= far * far && !cusps.uncertain().resolved(cusp.to, d) && !cusps.clear(cusp.to, d))
      cusps.uncertain().add(cusp.to, d);
}

// @return false if the loop has vanished because its cusps have passed each other
bool Drawer::move_cusps() {
  const std::size_t n = line_.size();
  const double area = twice_area();
  left_out_.clear();
  for (const Cusp& cusp : cusps_) line_[cusp.place] = cusp.to;
  for (const Cusp& cusp : cusps_) {
    const geometry::Vec way = cusp.to - cusp.from;
    if (dot(way, cusp.outward) >= 0) continue;
    // A cusp that moves back removes the points that it passes.
    const double reach = 4 * dot(way, way);
    for (const std::size_t step : {std::size_t(1), n - 1})
      for (std::size_t i = (cusp.place + step) % n; i != cusp.place; i = (i + step) % n) {
        const geometry::Vec off = line_[i] - cusp.to, from = line_[i] - cusp.from;
        if (dot(off, cusp.outward) <= 0 || dot(from, from) > reach) break;
        left_out_.push_back(std::uint32_t(i));
      }
  }
  leave_out();
  if (line_.size() < 3) return false;
  twice_area_ = twice_area();
  return twice_area_ * area > 0;
}

// Removes the listed points except cusps.
void Drawer::leave_out() {
  if (left_out_.empty()) return;
  std::sort(left_out_.begin(), left_out_.end());
  const auto is_cusp = [&](std::size_t place) {
    return std::any_of(cusps_.begin(), cusps_.end(), [&](const Cusp& cusp) { return cusp.place == place; });
  };
  std::size_t kept = left_out_[0];
  auto next = left_out_.begin();
  for (std::size_t i = kept; i < line_.size(); ++i) {
    const bool listed = next != left_out_.end() && *next == i;
    while (next != left_out_.end() && *next == i) ++next;
    if (!listed || is_cusp(i)) line_[kept++] = line_[i];
  }
  line_.resize(kept);
}

// Returns whether the mean width is below `width`, as far as the extents along the axes show.
bool Drawer::looks_narrow_on_average(double width) const {
  geometry::Lanes2 along_axes{}, at{line_.back().x, line_.back().y};
  for (const geometry::Vec v : line_) {
    const geometry::Lanes2 next{v.x, v.y}, way = next - at;
    along_axes += way > -way ? way : -way;
    at = next;
  }
  return std::abs(twice_area_) < width * (along_axes[0] + along_axes[1]);
}

double Drawer::twice_area() const {
  double sum = 0;
  for (std::size_t i = 1; i + 1 < line_.size(); ++i)
    sum += cross(line_[i] - line_[0], line_[i + 1] - line_[0]);
  return sum;
}

}  // namespace firn::slice::wavefront
