#include "core/slice/thin.h"
#include "core/slice/wavefront.h"

namespace firn::slice::wavefront {
namespace {

constexpr double kStraight = 0.02;  // sine of a bend that is none
constexpr int kDeepest = 12;  // an arc becomes 4096 chords at most

// Places strictly between a and b (directions from the centre of length d). They stand outside the arc by two thirds of what
// the chords between them bulge: those run as far inside it as outside, and the first and last one too far inside by two
// thirds as well. All halves of a level are alike, so that one root serves a level.
class Arc {
 public:
  Arc(Vec centre, double d, std::vector<Vec>& line) : centre_(centre), line_(line), d_(d) {}

  void add(Vec a, Vec b, double within) {
    // A chord's middle lies |a + b| / 2 from the centre.
    const auto square_at = [&](double bulge) { return bulge < d_ ? 4 * (d_ - bulge) * (d_ - bulge) : 0.0; };
    double square = dot(a + b, a + b), enough = square_at(within);
    if (square >= enough || square <= 0) return;
    enough = square_at(1.5 * within);
    int levels = 0;
    do {
      const double l = std::sqrt(square);
      factor_[levels] = d_ / l;
      square = 2 * d_ * (d_ + 0.5 * l);  // of the halves: cos^2 of half an angle
    } while (++levels < kDeepest && square < enough && square > 0);
    outside_ = 1 + 2.0 / 3.0 * (1 - 0.5 * std::sqrt(square) / d_);
    halve(a, b, 0, levels);
  }

 private:
  void halve(Vec a, Vec b, int level, int levels) {
    const Vec middle = factor_[level] * (a + b);
    if (level + 1 < levels) halve(a, middle, level + 1, levels);
    line_.push_back(centre_ + outside_ * middle);
    if (level + 1 < levels) halve(middle, b, level + 1, levels);
  }

  Vec centre_;
  std::vector<Vec>& line_;
  double d_;
  double outside_ = 1;
  double factor_[kDeepest] = {};
};

}  // namespace

void Drawer::operator()(std::span<const Source> sources, const Component& component, double d, double tolerance, Rings& rings,
                        ExactTips* tips) {
  // One fifth of the tolerance for the arcs' chords, the rest for leaving points out; never finer than 1 um.
  const double within = std::max(10.0, 0.2 * tolerance), thinning = 0.8 * tolerance;
  std::size_t begin = 0;
  for (const std::uint32_t end : component.ends) {
    line_.clear();
    tips_.clear();
    bends_.clear();
    for (std::size_t i = begin; i < end; ++i) {
      const Piece& piece = component.pieces[i];
      const Source& source = sources[piece.source];
      if (tips) bend(sources[component.pieces[i > begin ? i - 1 : end - 1].source], source, piece.from, d, *tips);
      line_.push_back(piece.from);
      if (!source.corner()) continue;
      const Vec to = component.pieces[i + 1 < end ? i + 1 : begin].from;
      Arc(source.at, d, line_).add(piece.from - source.at, to - source.at, within);
    }
    begin = end;
    if (!tips_.empty() && !move_tips()) continue;
    thin_ring(line_, thinning, rings);
  }
}

// Where the front goes from one source to the next. Bends that follow each other closely are one tip, as sharp as all of them.
void Drawer::bend(const Source& before, const Source& after, Vec at, double d, ExactTips& tips) {
  const auto wall = [&](const Source& s) -> ExactTips::Wall {
    if (!s.corner()) return {at - d * left_of(s.along), s.along};
    return {s.at, (1 / d) * right_of(at - s.at)};
  };
  const ExactTips::Wall a = wall(before), b = wall(after);
  const double near = tips.near();
  if (bends_.empty() || dot(at - bends_.back().at, at - bends_.back().at) > near * near) bends_.clear();
  const bool sharp = !bends_.empty() && bends_.front().sharp;
  bends_.push_back({at, a, b, line_.size(), sharp});
  const Vec from = bends_.front().before.along;
  if (!sharp && (dot(from, b.along) > ExactTips::kTip || cross(from, b.along) <= 0)) return;
  bends_.front().sharp = true;
  for (std::size_t i = sharp ? bends_.size() - 1 : 0; i < bends_.size(); ++i) {
    const Bend& bend = bends_[i];
    if (cross(bend.before.along, bend.after.along) < kStraight) continue;
    Vec to = bend.at;
    if (tips.move(to, bend.before, bend.after, d))
      tips_.push_back({bend.place, bend.at, to, right_of(bend.before.along) + right_of(bend.after.along)});
  }
}

// @return false if nothing is left of the line: its tips have passed each other
bool Drawer::move_tips() {
  const std::size_t n = line_.size();
  const double area = twice_area();
  left_out_.assign(n, false);
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
        left_out_[i] = true;
      }
  }
  for (const Tip& tip : tips_) left_out_[tip.place] = false;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < n; ++i)
    if (!left_out_[i]) line_[kept++] = line_[i];
  line_.resize(kept);
  return kept >= 3 && twice_area() * area > 0;
}

double Drawer::twice_area() const {
  double sum = 0;
  for (std::size_t i = 1; i + 1 < line_.size(); ++i) sum += cross(line_[i] - line_[0], line_[i + 1] - line_[0]);
  return sum;
}

}  // namespace firn::slice::wavefront
