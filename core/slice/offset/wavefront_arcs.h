// DirectedArc holds an arc or a segment of the wavefront at one distance; intersect() computes the crossings
// of two of them.
#pragma once

#include "core/geometry/monotone_chains.h"
#include "core/slice/offset/wavefront.h"

namespace firn::slice::wavefront {

inline constexpr std::int32_t kPivot = -1;  // instead of a site: a segment to or from a pivot

// A part of a loop: a wavefront edge, or one of the two segments to and from a pivot.
struct DirectedArc {
  geometry::Vec a, b;
  std::int32_t edge = 0;  // index into the edges of the component
  std::int32_t site = 0;
  std::uint32_t next = 0;  // in its loop
};

inline bool is_circular(std::span<const Site> sites, const DirectedArc& s) {
  return s.site != kPivot && sites[std::size_t(s.site)].corner();
}

// The crossing of two arcs.
struct Crossing {
  geometry::Vec at;
  std::uint32_t arc[2];
  double place[2];  // position along each arc
};

// Returns the monotonicity (MonotoneChains::Run) of the edge of a site at distance d. A circular arc of at
// most half a turn whose ends have the same signs of direction is monotone, and one of less than a quarter
// turn has an extremum along at most one axis. An arc that has collapsed may not end on its circle.
inline int run_of(const Site& site, geometry::Vec from, geometry::Vec to, double d) {
  if (!site.corner()) return geometry::MonotoneChains::run_of(to - from);
  const geometry::Vec a = from - site.at, b = to - site.at;
  const double square = d * d;
  if (std::abs(dot(a, a) - square) >= d || std::abs(dot(b, b) - square) >= d || cross(a, b) > 0)
    return geometry::MonotoneChains::kBent;
  const int run = geometry::MonotoneChains::run_of(right_of(a)),
            turned = run ^ geometry::MonotoneChains::run_of(right_of(b));
  if (turned == 0) return run;
  return dot(a, b) > 0 ? run | turned << 2 : int(geometry::MonotoneChains::kBent);
}

// Returns the box of an arc at distance d.
inline geometry::BoxOf<double> box_of(std::span<const Site> sites, const DirectedArc& s, double d) {
  // A circular arc of at most half a turn bulges by less than its squared chord over 4 d.
  const double bulge = is_circular(sites, s) ? dot(s.b - s.a, s.b - s.a) / (4 * d) : 0.0;
  return {std::min(s.a.x, s.b.x) - bulge, std::min(s.a.y, s.b.y) - bulge, std::max(s.a.x, s.b.x) + bulge,
          std::max(s.a.y, s.b.y) + bulge};
}

inline geometry::PairBox bent_box(std::span<const Site> sites, const DirectedArc& arc, double d) {
  const geometry::BoxOf<double> box = box_of(sites, arc, d);
  return geometry::PairBox::of(geometry::Vec{box.x0, box.y0}, geometry::Vec{box.x1, box.y1});
}

// The interface that MonotoneChains requires of directed arcs.
struct ArcEdges {
  std::span<const Site> sites;
  const DirectedArc* arcs;
  double d;
  geometry::Vec from(std::size_t i) const { return arcs[i].a; }
  geometry::Vec to(std::size_t i) const { return arcs[i].b; }
  geometry::PairBox bent(std::size_t i) const { return bent_box(sites, arcs[i], d); }
  std::size_t next(std::size_t i) const { return arcs[i].next; }
  const DirectedArc& arc(std::size_t i) const { return arcs[i]; }
};

// The same for loops without pivots, whose edges are their arcs.
struct LoopEdges {
  std::span<const Site> sites;
  std::span<const WavefrontEdge> edges;
  const std::uint32_t* after;  // successor of each edge; null if there is one loop
  double d;
  geometry::Vec from(std::size_t i) const { return edges[i].from; }
  geometry::Vec to(std::size_t i) const { return edges[next(i)].from; }
  geometry::PairBox bent(std::size_t i) const { return bent_box(sites, arc(i), d); }
  std::size_t next(std::size_t i) const { return after ? after[i] : i + 1 < edges.size() ? i + 1 : 0; }
  DirectedArc arc(std::size_t i) const {
    return {from(i), to(i), std::int32_t(i), edges[i].site, std::uint32_t(next(i))};
  }
};

// Calls found(point, position on a, position on b) for each crossing of two arcs of the wavefront at distance
// d. The position on an arc increases from its a to its b, which is not part of it.
template <class F>
void intersect(std::span<const Site> sites, double d, const DirectedArc& a, const DirectedArc& b, F&& found) {
  const auto along = [&](const DirectedArc& s, geometry::Vec p, double& place) {
    if (!is_circular(sites, s)) {
      const geometry::Vec way = s.b - s.a;
      place = dot(p - s.a, way);
      return place >= 0 && place < dot(way, way);
    }
    const Site& site = sites[std::size_t(s.site)];
    if (dot(p - site.at, left_of(site.along)) <= 0) return false;
    place = dot(p - site.at, site.along);
    return place >= dot(s.a - site.at, site.along) && place < dot(s.b - site.at, site.along);
  };
  const auto offer = [&](geometry::Vec p) {
    double on_a = 0, on_b = 0;
    if (along(a, p, on_a) && along(b, p, on_b)) found(p, on_a, on_b);
  };
  const bool a_bends = is_circular(sites, a), b_bends = is_circular(sites, b);
  if (!a_bends && !b_bends) {
    const geometry::Vec wa = a.b - a.a, wb = b.b - b.a;
    const double sine = cross(wa, wb);
    if (sine == 0) return;
    const double s = cross(b.a - a.a, wb) / sine, t = cross(b.a - a.a, wa) / sine;
    if (s >= 0 && s < 1 && t >= 0 && t < 1) found(a.a + s * wa, s * dot(wa, wa), t * dot(wb, wb));
    return;
  }
  if (a_bends && b_bends) {
    const geometry::Vec ca = sites[std::size_t(a.site)].at, between = sites[std::size_t(b.site)].at - ca;
    const double square = dot(between, between), height = d * d - 0.25 * square;
    if (square == 0 || height <= 0) return;
    const geometry::Vec side = std::sqrt(height / square) * left_of(between), mid = ca + 0.5 * between;
    offer(mid + side);
    offer(mid - side);
    return;
  }
  const DirectedArc &line = a_bends ? b : a, &bow = a_bends ? a : b;
  const geometry::Vec way = line.b - line.a, centre = sites[std::size_t(bow.site)].at;
  const double square = dot(way, way);
  if (square == 0) return;
  const double foot = dot(centre - line.a, way) / square;
  const geometry::Vec off = line.a + foot * way - centre;
  const double height = d * d - dot(off, off);
  if (height <= 0) return;
  const double half = std::sqrt(height / square);
  offer(line.a + (foot - half) * way);
  offer(line.a + (foot + half) * way);
}

}  // namespace firn::slice::wavefront
