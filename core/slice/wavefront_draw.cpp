#include "core/slice/thin.h"
#include "core/slice/wavefront.h"

namespace firn::slice::wavefront {
namespace {

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

void draw(std::span<const Source> sources, const Component& component, double d, double tolerance, std::vector<Vec>& line,
          Rings& rings) {
  // One fifth of the tolerance for the arcs' chords, the rest for leaving points out; never finer than 1 um.
  const double within = std::max(10.0, 0.2 * tolerance), thinning = 0.8 * tolerance;
  std::size_t begin = 0;
  for (const std::uint32_t end : component.ends) {
    line.clear();
    for (std::size_t i = begin; i < end; ++i) {
      const Piece& piece = component.pieces[i];
      line.push_back(piece.from);
      const Source& source = sources[piece.source];
      if (!source.corner()) continue;
      const Vec to = component.pieces[i + 1 < end ? i + 1 : begin].from;
      Arc(source.at, d, line).add(piece.from - source.at, to - source.at, within);
    }
    begin = end;
    thin_ring(line, thinning, rings);
  }
}

}  // namespace firn::slice::wavefront
