#include <algorithm>

#include "core/slice/offset/wavefront.h"

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

// Twice the area of a loop; of its chords alone where no arc can change the sign.
double area(std::span<const Source> sources, std::span<const Piece> pieces, double d) {
  const Vec origin = pieces[0].from;
  double sum = 0, edge = 0, longest = 0;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const Vec a = pieces[i].from, b = pieces[i + 1 < pieces.size() ? i + 1 : 0].from, way = b - a;
    sum += cross(a - origin, b - origin);
    edge += std::abs(way.x) + std::abs(way.y);
    longest = std::max(longest, dot(way, way));
  }
  // Between an arc of at most half a turn and its chord c lies less than c^3 / 5 d.
  if (5 * d * std::abs(sum) > 2 * longest * edge) return sum;
  sum = 0;
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

void Regroup::operator()(std::span<const Source> sources, Components& loops, double d, Components& out) {
  areas_.clear();
  outers_.clear();
  for (const Component& loop : loops.all()) {
    areas_.push_back(area(sources, loop.pieces, d));
    if (areas_.back() > 0) outers_.push_back(areas_.size() - 1);
  }
  const std::span<Component> all = loops.all();
  if (outers_.size() < all.size()) list_holes(sources, all, d);
  for (std::size_t outer = 0; outer < all.size(); ++outer) {
    if (areas_[outer] <= 0) continue;
    Component& component = all[outer];
    for (std::size_t hole = 0; hole < (outers_.size() < all.size() ? all.size() : 0); ++hole) {
      if (outer_of_[hole] != outer) continue;
      component.pieces.insert(component.pieces.end(), all[hole].pieces.begin(), all[hole].pieces.end());
      component.ends.push_back(std::uint32_t(component.pieces.size()));
    }
    out.take(component);
  }
}

// Each with the smallest of the outer loops that it lies in.
void Regroup::list_holes(std::span<const Source> sources, std::span<const Component> loops, double d) {
  outer_of_.assign(loops.size(), kNone);
  std::stable_sort(outers_.begin(), outers_.end(),
                   [&](std::size_t a, std::size_t b) { return areas_[a] < areas_[b]; });
  corners_.resize(std::max(corners_.size(), outers_.size()));
  if (outers_.size() > 1)
    for (std::size_t o = 0; o < outers_.size(); ++o) {
      corners_[o].clear();
      each_corner(sources, loops[outers_[o]].pieces, d, [&](Vec corner) { corners_[o].push_back(corner); });
    }
  for (std::size_t hole = 0; hole < loops.size(); ++hole) {
    if (areas_[hole] > 0) continue;
    for (std::size_t o = 0; o < outers_.size() && outer_of_[hole] == kNone; ++o)
      if (outers_.size() == 1 || inside(corners_[o], loops[hole].pieces[0].from))
        outer_of_[hole] = outers_[o];
  }
}

}  // namespace firn::slice::wavefront
