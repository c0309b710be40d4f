#include "core/slice/thin.h"
#include "core/slice/wavefront.h"

namespace firn::slice::wavefront {
namespace {

// Places on the arc between a and b (directions from the centre of length d), chords within `sagitta` of it.
void add_arc(Vec centre, Vec a, Vec b, double d, double sagitta, std::vector<Vec>& line, int depth = 0) {
  const Vec sum = a + b;
  const double l = length(sum);
  if (d - 0.5 * l <= sagitta || depth == 12 || l == 0) return;
  const Vec middle = (d / l) * sum;
  add_arc(centre, a, middle, d, sagitta, line, depth + 1);
  line.push_back(centre + middle);
  add_arc(centre, middle, b, d, sagitta, line, depth + 1);
}

}  // namespace

void draw(std::span<const Source> sources, const Component& component, double d, double tolerance, Rings& rings) {
  // One third of the tolerance for the arcs' chords, the rest for leaving points out; never finer than 1 um.
  const double sagitta = std::max(10.0, 0.33 * tolerance), thinning = 0.66 * tolerance;
  std::vector<Vec> line;
  std::size_t begin = 0;
  for (const std::uint32_t end : component.ends) {
    line.clear();
    for (std::size_t i = begin; i < end; ++i) {
      const Piece& piece = component.pieces[i];
      line.push_back(piece.from);
      const Source& source = sources[piece.source];
      if (!source.corner()) continue;
      const Vec to = component.pieces[i + 1 < end ? i + 1 : begin].from;
      add_arc(source.at, piece.from - source.at, to - source.at, d, sagitta, line);
    }
    begin = end;
    thin_ring(line, thinning, rings);
  }
}

}  // namespace firn::slice::wavefront
