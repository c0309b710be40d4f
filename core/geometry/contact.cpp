#include <cmath>

#include "core/geometry/edge_grid.h"
#include "core/geometry/planar.h"

namespace firn::slice {
namespace {

// Neighbours share their point; they have more in common only where the ring folds back on itself.
bool folds(const Edge& e, const Edge& following) {
  if (orientation(e.a, e.b, following.b) != 0) return false;
  const double forward = (double(e.b.x) - e.a.x) * (double(following.b.x) - following.a.x) +
                         (double(e.b.y) - e.a.y) * (double(following.b.y) - following.a.y);
  return !(forward > 0.0);  // on one line, so far from 0 unless an edge has no length
}

Point place_of(const Edge& e, const Edge& f) {
  for (const Point& p : {f.a, f.b})
    if (touch(e, {p, p})) return p;
  return touch(f, {e.a, e.a}) ? e.a : e.b;
}

}  // namespace

std::optional<Contact> first_contact(const Rings& rings) {
  std::vector<Edge> edges;
  std::vector<std::uint32_t> next;
  edges.reserve(rings.points.size());
  next.reserve(rings.points.size());
  for (std::size_t r = 0; r < rings.size(); ++r) {
    const std::span<const Point> ring = rings[r];
    if (ring.size() < 3) return Contact{r, r, ring.empty() ? Point{} : ring[0]};
    const std::size_t first = edges.size();
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const bool last = i + 1 == ring.size();
      edges.push_back({ring[i], ring[last ? 0 : i + 1]});
      next.push_back(std::uint32_t(last ? first : edges.size()));
    }
  }
  const auto contact = [&](std::uint32_t i, std::uint32_t j) {
    const auto ring_of = [&](std::uint32_t e) {
      return std::size_t(std::upper_bound(rings.ends.begin(), rings.ends.end(), e) - rings.ends.begin());
    };
    return Contact{ring_of(i), ring_of(j), place_of(edges[i], edges[j])};
  };
  for (std::uint32_t i = 0; i < edges.size(); ++i)
    if (folds(edges[i], edges[next[i]])) return contact(i, next[i]);
  EdgeGrid grid;
  grid.build(edges, 0);
  for (std::size_t n = 0; n < grid.cells(); ++n) {
    const std::span<const std::uint32_t> cell = grid.cell(n);
    for (std::size_t a = 0; a + 1 < cell.size(); ++a) {
      const Edge& e = edges[cell[a]];
      for (std::size_t b = a + 1; b < cell.size(); ++b)
        if (boxes_meet(e, edges[cell[b]]) && next[cell[a]] != cell[b] && next[cell[b]] != cell[a] &&
            touch(e, edges[cell[b]]))
          return contact(cell[a], cell[b]);
    }
  }
  return std::nullopt;
}

bool simple_and_apart(const Rings& rings) { return !first_contact(rings); }

}  // namespace firn::slice
