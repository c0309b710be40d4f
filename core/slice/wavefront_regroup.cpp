#include <algorithm>

#include "core/slice/wavefront.h"

namespace firn::slice::wavefront {
namespace {

// The corners of a loop, with the middles of its arcs: enough to tell its direction and what lies in it.
template <class F>
void each_corner(std::span<const Source> sources, std::span<const Piece> pieces, double d, F&& f) {
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    f(pieces[i].from);
    const Source& source = sources[std::size_t(pieces[i].source)];
    if (source.corner()) f(middle(source, pieces[i].from, pieces[i + 1 < pieces.size() ? i + 1 : 0].from, d));
  }
}

double area(std::span<const Source> sources, std::span<const Piece> pieces, double d) {
  const Vec origin = pieces[0].from;
  double sum = 0;
  Vec before;
  each_corner(sources, pieces, d, [&](Vec corner) {
    const Vec here = corner - origin;
    sum += cross(before, here);
    before = here;
  });
  return sum;
}

bool inside(std::span<const Vec> corners, Vec p) {
  bool in = false;
  Vec a = corners.back();
  for (const Vec b : corners) {
    if ((a.y <= p.y) != (b.y <= p.y) && a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x) > p.x) in = !in;
    a = b;
  }
  return in;
}

}  // namespace

Vec middle(const Source& source, Vec a, Vec b, double d) {
  if (!source.corner()) return 0.5 * (a + b);
  const Vec sum = (a - source.at) + (b - source.at);
  const double l = length(sum);
  return l > 0 ? source.at + (d / l) * sum : a;
}

void Regroup::operator()(std::span<const Source> sources, Component& loops, double d, Components& out) {
  const auto pieces_of = [&](const Loop& loop) { return std::span<const Piece>(loops.pieces).subspan(loop.begin, loop.end - loop.begin); };
  loops_.clear();
  outers_.clear();
  std::uint32_t begin = 0;
  for (const std::uint32_t end : loops.ends) {
    Loop loop{begin, end, kNone, 0, {}};
    loop.area = area(sources, pieces_of(loop), d);
    if (loop.area > 0) outers_.push_back(std::uint32_t(loops_.size()));
    loops_.push_back(loop);
    begin = end;
  }
  if (outers_.empty()) return;
  if (outers_.size() == 1 && outers_[0] == 0) return out.take(loops);
  list_holes(sources, loops, d);
  for (std::uint32_t outer = 0; outer < loops_.size(); ++outer) {
    if (loops_[outer].area <= 0) continue;
    Component& component = out.add();
    const auto add = [&](const Loop& loop) {
      component.pieces.insert(component.pieces.end(), loops.pieces.begin() + loop.begin, loops.pieces.begin() + loop.end);
      component.ends.push_back(std::uint32_t(component.pieces.size()));
    };
    add(loops_[outer]);
    if (loops_.size() == outers_.size()) continue;
    for (const Loop& hole : loops_)
      if (hole.outer == outer) add(hole);
  }
}

// Each with the smallest of the outer loops that it lies in.
void Regroup::list_holes(std::span<const Source> sources, const Component& loops, double d) {
  if (loops_.size() == outers_.size()) return;
  std::stable_sort(outers_.begin(), outers_.end(), [&](std::uint32_t a, std::uint32_t b) { return loops_[a].area < loops_[b].area; });
  if (outers_.size() > 1)
    for (const std::uint32_t outer : outers_) {
      std::vector<Vec>& corners = loops_[outer].corners;
      each_corner(sources, std::span(loops.pieces).subspan(loops_[outer].begin, loops_[outer].end - loops_[outer].begin), d,
                  [&](Vec corner) { corners.push_back(corner); });
    }
  for (Loop& loop : loops_) {
    if (loop.area > 0) continue;
    for (const std::uint32_t outer : outers_) {
      if (outers_.size() > 1 && !inside(loops_[outer].corners, loops.pieces[loop.begin].from)) continue;
      loop.outer = outer;
      break;
    }
  }
}

}  // namespace firn::slice::wavefront
