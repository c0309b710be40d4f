#include "core/slice/thin.h"
#include "core/slice/wavefront.h"

namespace firn::slice::wavefront {
namespace {

constexpr int kDeepest = 12;  // an arc becomes 4096 chords at most

// Places strictly between a and b (directions from the centre of length d), chords within `sagitta` of the arc. All halves
// of a level are alike, so that one root serves a level.
class Arc {
 public:
  Arc(Vec centre, double d, std::vector<Vec>& line) : centre_(centre), line_(line), d_(d) {}

  void add(Vec a, Vec b, double sagitta) {
    // A chord's middle lies |a + b| / 2 from the centre.
    const double least = d_ - sagitta, enough = least > 0 ? 4 * least * least : 0;
    double square = dot(a + b, a + b);
    int levels = 0;
    for (; square < enough && square > 0 && levels < kDeepest; ++levels) {
      const double l = std::sqrt(square);
      factor_[levels] = d_ / l;
      square = 2 * d_ * (d_ + 0.5 * l);  // of the halves: cos^2 of half an angle
    }
    if (levels) halve(a, b, 0, levels);
  }

 private:
  void halve(Vec a, Vec b, int level, int levels) {
    const Vec middle = factor_[level] * (a + b);
    if (level + 1 < levels) halve(a, middle, level + 1, levels);
    line_.push_back(centre_ + middle);
    if (level + 1 < levels) halve(middle, b, level + 1, levels);
  }

  Vec centre_;
  std::vector<Vec>& line_;
  double d_;
  double factor_[kDeepest] = {};
};

}  // namespace

void draw(std::span<const Source> sources, const Component& component, double d, double tolerance, std::vector<Vec>& line,
          Rings& rings) {
  // One third of the tolerance for the arcs' chords, the rest for leaving points out; never finer than 1 um.
  const double sagitta = std::max(10.0, 0.33 * tolerance), thinning = 0.66 * tolerance;
  std::size_t begin = 0;
  for (const std::uint32_t end : component.ends) {
    line.clear();
    for (std::size_t i = begin; i < end; ++i) {
      const Piece& piece = component.pieces[i];
      line.push_back(piece.from);
      const Source& source = sources[piece.source];
      if (!source.corner()) continue;
      const Vec to = component.pieces[i + 1 < end ? i + 1 : begin].from;
      Arc(source.at, d, line).add(piece.from - source.at, to - source.at, sagitta);
    }
    begin = end;
    thin_ring(line, thinning, rings);
  }
}

}  // namespace firn::slice::wavefront
