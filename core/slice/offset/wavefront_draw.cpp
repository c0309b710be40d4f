#include <algorithm>

#include "core/geometry/lanes.h"
#include "core/geometry/thin.h"
#include "core/slice/offset/wavefront.h"

namespace firn::slice::wavefront {
namespace {

constexpr double kStraight = 0.02;  // sine of a bend that is none
constexpr double kThin = 2;  // width of an area, in the distances within which bends are one tip, below which
                             // its tips are looked at
constexpr double kFar = 1.5;  // thinnings: no tip that moves by less is 0.05 mm too near to a third wall
constexpr int kDeepest = 12;  // an arc becomes 4096 chords at most

// Does a front turn to its left from one direction to another, or to and fro? Its turns to the right are
// arcs.
bool turns_by(Vec from, Vec to, double cosine, double sine = 0) {
  const double ahead = dot(from, to);
  return ahead < 0 || (ahead <= cosine && cross(from, to) > sine);
}

// Places strictly between a and b (directions from the centre of length d). They stand outside the arc by two
// thirds of what the chords between them bulge: those run as far inside it as outside, and the first and last
// one too far inside by two thirds as well. All halves of a level are alike, so that one root serves a level.
class Arcs {
 public:
  Arcs(double d, double within, std::vector<Vec>& line)
      : line_(line), d_(d), coarse_(square_at(within)), enough_(square_at(1.5 * within)) {}

  void add(Vec centre, Vec a, Vec b) {
    double square = dot(a + b, a + b);
    if (square >= coarse_ || square <= 0) return;
    int levels = 0;
    do {
      const double l = std::sqrt(square);
      factor_[levels] = d_ / l;
      square = 2 * d_ * (d_ + 0.5 * l);  // of the halves: cos^2 of half an angle
    } while (++levels < kDeepest && square < enough_ && square > 0);
    outside_ = 1 + 2.0 / 3.0 * (1 - 0.5 * std::sqrt(square) / d_);
    centre_ = centre;
    halve(a, b, 0, levels);
  }

 private:
  // A chord's middle lies |a + b| / 2 from the centre.
  double square_at(double bulge) const { return bulge < d_ ? 4 * (d_ - bulge) * (d_ - bulge) : 0.0; }

  void halve(Vec a, Vec b, int level, int levels) {
    const Vec middle = factor_[level] * (a + b);
    if (level + 1 < levels) halve(a, middle, level + 1, levels);
    line_.push_back(centre_ + outside_ * middle);
    if (level + 1 < levels) halve(middle, b, level + 1, levels);
  }

  std::vector<Vec>& line_;
  double d_, coarse_, enough_;
  double outside_ = 1;
  Vec centre_;
  double factor_[kDeepest] = {};
};

}  // namespace

void Drawer::operator()(std::span<const Source> sources, const Component& component, double d,
                        double tolerance, Rings& rings, ExactTips* tips) {
  // One fifth of the tolerance for the arcs' chords, the rest for leaving points out; never finer than 1 um.
  const double within = std::max(10.0, 0.2 * tolerance), thinning = 0.8 * tolerance;
  const double near = tips ? tips->near() * tips->near() : 0, inverse = 1 / d;
  Arcs arcs(d, within, line_);
  std::size_t begin = 0;
  for (const std::uint32_t end : component.ends) {
    const std::span<const Piece> loop = std::span(component.pieces).subspan(begin, end - begin);
    begin = end;
    line_.clear();
    tips_.clear();
    if (tips) places_.resize(loop.size());
    Bends bends;
    Vec at = loop[0].from;
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const Source& source = sources[std::size_t(loop[i].source)];
      if (tips) {
        places_[i] = std::uint32_t(line_.size());
        if (i == 0 || dot(at - bends.last, at - bends.last) > near) {
          const Source& before = sources[std::size_t(loop[i > 0 ? i - 1 : loop.size() - 1].source)];
          bends = {i, before.corner() ? inverse * right_of(at - before.at) : before.along, at, false};
        }
        bends.last = at;
        const Vec along = source.corner() ? inverse * right_of(at - source.at) : source.along;
        if (bends.sharp) {
          tip_at(sources, loop, bends.first, i, d, *tips);
        } else if (turns_by(bends.from, along, ExactTips::kTip)) {
          bends.sharp = true;
          for (std::size_t k = bends.first; k <= i; ++k) tip_at(sources, loop, bends.first, k, d, *tips);
        }
      }
      line_.push_back(at);
      const Vec to = loop[i + 1 < loop.size() ? i + 1 : 0].from;
      if (source.corner()) arcs.add(source.at, at - source.at, to - source.at);
      at = to;
    }
    if (!tips_.empty()) {
      if (!move_tips()) continue;
      if (tips->asks()) list_third_walls(*tips, d);
    }
    thin_ring(line_, thinning, rings);
  }
}

// At the start of a piece. @param first piece of those whose starts are one tip with it
void Drawer::tip_at(std::span<const Source> sources, std::span<const Piece> loop, std::size_t first,
                    std::size_t piece, double d, ExactTips& tips) {
  const Vec at = loop[piece].from;
  const auto wall = [&](std::size_t p) -> ExactTips::Wall {
    const Source& s = sources[std::size_t(loop[p].source)];
    if (!s.corner()) return {at - d * left_of(s.along), s.along};
    return {s.at, (1 / d) * right_of(at - s.at)};
  };
  const ExactTips::Wall before = wall(piece > 0 ? piece - 1 : loop.size() - 1), after = wall(piece);
  if (!turns_by(before.along, after.along, 1, kStraight)) return;
  Vec to = at;
  if (!tips.move(to, before, after, d)) return;
  tips_.push_back(
      {places_[piece], at, to, right_of(before.along) + right_of(after.along), before, std::uint32_t(piece)});
  for (std::size_t last = tips_.size() - 1; last > 0; --last) {
    const Tip &one = tips_[last - 1], &other = tips_[last];
    if (one.piece < first || dot(other.to - one.to, other.before.along) >= 0) return;
    // They have passed each other: of what was between them nothing is left.
    to = 0.5 * (one.from + at);
    if (!tips.move(to, one.before, after, d)) return;
    for (std::size_t k = last - 1; k < tips_.size(); ++k) tips_[k].to = to;
  }
}

// Tips may be nearer to a wall than to the two that make them.
void Drawer::list_third_walls(ExactTips& tips, double d) const {
  const double far = looks_thin(kThin * tips.near()) ? 0 : kFar * tips.thinned();
  for (const Tip& tip : tips_)
    if (const Vec way = tip.to - tip.from;
        dot(way, way) >= far * far && !tips.doubts().settled(tip.to, d) && !tips.clear(tip.to, d))
      tips.doubts().add(tip.to, d);
}

// @return false if nothing is left of the line: its tips have passed each other
bool Drawer::move_tips() {
  const std::size_t n = line_.size();
  const double area = twice_area();
  left_out_.clear();
  for (const Tip& tip : tips_) line_[tip.place] = tip.to;
  for (const Tip& tip : tips_) {
    const Vec way = tip.to - tip.from;
    if (dot(way, tip.outward) >= 0) continue;
    // A tip that moves back takes with it what it has passed.
    const double reach = 4 * dot(way, way);
    for (const std::size_t step : {std::size_t(1), n - 1})
      for (std::size_t i = (tip.place + step) % n; i != tip.place; i = (i + step) % n) {
        const Vec off = line_[i] - tip.to, from = line_[i] - tip.from;
        if (dot(off, tip.outward) <= 0 || dot(from, from) > reach) break;
        left_out_.push_back(std::uint32_t(i));
      }
  }
  leave_out();
  if (line_.size() < 3) return false;
  twice_area_ = twice_area();
  return twice_area_ * area > 0;
}

// Tips stay.
void Drawer::leave_out() {
  if (left_out_.empty()) return;
  std::sort(left_out_.begin(), left_out_.end());
  const auto is_tip = [&](std::size_t place) {
    return std::any_of(tips_.begin(), tips_.end(), [&](const Tip& tip) { return tip.place == place; });
  };
  std::size_t kept = left_out_[0];
  auto next = left_out_.begin();
  for (std::size_t i = kept; i < line_.size(); ++i) {
    const bool listed = next != left_out_.end() && *next == i;
    while (next != left_out_.end() && *next == i) ++next;
    if (!listed || is_tip(i)) line_[kept++] = line_[i];
  }
  line_.resize(kept);
}

// Is it narrower than a width on average, as far as its extents along the axes tell?
bool Drawer::looks_thin(double width) const {
  Lanes2 along_axes{}, at{line_.back().x, line_.back().y};
  for (const Vec v : line_) {
    const Lanes2 next{v.x, v.y}, way = next - at;
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
