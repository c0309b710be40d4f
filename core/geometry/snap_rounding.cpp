#include <algorithm>
#include <tuple>

#include "core/geometry/exact.h"
#include "core/geometry/overlay.h"
#include "core/geometry/rtree.h"

namespace firn::geometry {
namespace {

std::int64_t floor_divided(__int128 n, __int128 d) {  // d > 0
  __int128 q = n / d;
  if (n % d < 0) --q;
  return std::int64_t(q);
}

// Returns a + (b - a) n / d rounded to the nearest grid point, halves upward: the centre of the square [x -
// 1/2, x + 1/2) that contains it.
Point along(const Edge& e, std::int64_t n, std::int64_t d) {
  if (d < 0) {
    n = -n;
    d = -d;
  }
  const auto rounded = [&](std::int64_t from, std::int64_t to) {
    return std::int32_t(from + floor_divided(2 * __int128(to - from) * n + d, 2 * __int128(d)));
  };
  return {rounded(e.a.x, e.b.x), rounded(e.a.y, e.b.y)};
}

// Computes the proper crossing of two edges. Their end points are hot anyway.
bool crossing(const Edge& e, const Edge& f, Point& at) {
  const std::int64_t fa = orientation(e.a, e.b, f.a), fb = orientation(e.a, e.b, f.b);
  const std::int64_t ea = orientation(f.a, f.b, e.a), eb = orientation(f.a, f.b, e.b);
  if (sign(fa) * sign(fb) >= 0 || sign(ea) * sign(eb) >= 0) return false;
  // ea and eb have opposite signs: halving keeps their difference within 64 bits and moves the ratio by
  // 2^-60.
  const __int128 d = __int128(ea) - eb;
  if (d > INT64_MAX || d < INT64_MIN)
    at = along(e, ea / 2, ea / 2 - eb / 2);
  else
    at = along(e, ea, std::int64_t(d));
  return true;
}

// Returns whether the edge passes the square [x - 1/2, x + 1/2) x [y - 1/2, y + 1/2). The separating axes are
// x, y and the normal of the edge; a line that touches only a corner meets the half-open square at its lower
// left.
bool passes(const Edge& e, const Point& p) {
  if (p.x < std::min(e.a.x, e.b.x) || p.x > std::max(e.a.x, e.b.x) || p.y < std::min(e.a.y, e.b.y) ||
      p.y > std::max(e.a.y, e.b.y))
    return false;
  const std::int64_t dx = std::int64_t(e.b.x) - e.a.x, dy = std::int64_t(e.b.y) - e.a.y;
  const std::int64_t reach = std::abs(dx) + std::abs(dy), side = orientation(e.a, e.b, p);
  if (std::abs(side) > reach / 2) return false;
  if (reach % 2 != 0 || std::abs(side) != reach / 2) return true;
  return (dx > 0) != (dy > 0) && (side > 0) == (dx > 0);
}

// A hot square that an edge passes.
struct Stop {
  std::uint32_t edge;
  Point at;
  bool operator==(const Stop&) const = default;
};

void add_edges(const Rings& rings, std::vector<Edge>& edges) {
  for (std::size_t r = 0; r < rings.size(); ++r) {
    const std::span<const Point> ring = rings[r];
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const Point& q = ring[i + 1 < ring.size() ? i + 1 : 0];
      if (ring[i] != q) edges.push_back({ring[i], q});
    }
  }
}

std::vector<Point> hot_points(const std::vector<Edge>& edges, const StaticRTree& tree) {
  std::vector<Point> hot;
  hot.reserve(edges.size());
  for (const Edge& e : edges) hot.push_back(e.a);  // rings: each point begins an edge
  tree.pairs([&](std::size_t i, std::size_t j) {
    Point at;
    if (crossing(edges[i], edges[j], at)) hot.push_back(at);
  });
  return hot;
}

// Lists hot squares edge after edge, without the end points of the edge. Along an edge they are ordered by
// the x and then the y of their centres in the direction of the edge.
std::vector<Stop> stops(const std::vector<Edge>& edges, const StaticRTree& tree,
                        const std::vector<Point>& hot) {
  std::vector<Stop> stops;
  for (const Point& p : hot)
    tree.touching({p.x, p.y, p.x, p.y}, [&](std::size_t e) {
      if (edges[e].a != p && edges[e].b != p && passes(edges[e], p)) stops.push_back({std::uint32_t(e), p});
    });
  const auto key = [&](const Stop& s) {
    const Edge& e = edges[s.edge];
    return std::tuple(s.edge, e.b.x < e.a.x ? -s.at.x : s.at.x, e.b.y < e.a.y ? -s.at.y : s.at.y);
  };
  std::sort(stops.begin(), stops.end(), [&](const Stop& a, const Stop& b) { return key(a) < key(b); });
  stops.erase(std::unique(stops.begin(), stops.end()), stops.end());
  return stops;
}

}  // namespace

std::vector<Subedge> snap_rounded(const Rings& first, const Rings& second) {
  std::vector<Edge> edges;
  add_edges(first, edges);
  const std::size_t of_first = edges.size();
  add_edges(second, edges);
  const StaticRTree tree = tree_of(edges);
  const std::vector<Stop> way = stops(edges, tree, hot_points(edges, tree));
  std::vector<Subedge> subedges;
  subedges.reserve(edges.size() + way.size());
  auto stop = way.begin();
  for (std::uint32_t e = 0; e < edges.size(); ++e) {
    Point from = edges[e].a;
    const auto lead = [&](const Point& to) {
      const bool up = from < to;
      Subedge& subedge = subedges.emplace_back();
      subedge.a = up ? from : to;
      subedge.b = up ? to : from;
      subedge.runs[e < of_first ? 0 : 1] = up ? 1 : -1;
      from = to;
    };
    for (; stop != way.end() && stop->edge == e; ++stop) lead(stop->at);
    lead(edges[e].b);
  }
  std::sort(subedges.begin(), subedges.end(),
            [](const Subedge& p, const Subedge& q) { return std::tie(p.a, p.b) < std::tie(q.a, q.b); });
  std::size_t kept = 0;
  for (std::size_t i = 0; i < subedges.size();) {
    Subedge sum = subedges[i];
    for (++i; i < subedges.size() && subedges[i].a == sum.a && subedges[i].b == sum.b; ++i)
      for (std::size_t k = 0; k < 2; ++k) sum.runs[k] += subedges[i].runs[k];
    if (sum.runs[0] != 0 || sum.runs[1] != 0) subedges[kept++] = sum;
  }
  subedges.resize(kept);
  return subedges;
}

}  // namespace firn::geometry
