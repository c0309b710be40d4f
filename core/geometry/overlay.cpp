#include "core/geometry/overlay.h"

#include <algorithm>
#include <tuple>

#include "core/geometry/intersection.h"
#include "core/geometry/planar.h"
#include "core/geometry/rings.h"
#include "core/geometry/winding.h"

namespace firn::geometry {
namespace {

// Orders directions to the right (or straight up) from the steepest down to the steepest up.
bool lower_direction(const Subedge& p, const Subedge& q) { return orientation(p.a, p.b, q.b) > 0; }

struct Directed {
  Point from, to;  // the area lies on the left
};

// Of the directed edges that leave `edge.to`, returns the one that bounds the same wedge of the area: the
// first clockwise from the reverse of `edge`.
std::size_t next_out(const std::vector<Directed>& edges, std::size_t first, std::size_t end,
                     const Directed& edge) {
  if (end - first == 1) return first;
  const Point &v = edge.to, &back = edge.from;
  // Clockwise angle from `back`: below 180 degrees comes first.
  const auto late = [&](const Point& w) { return orientation(v, back, w) >= 0; };
  std::size_t best = first;
  for (std::size_t i = first + 1; i < end; ++i) {
    const Point &w = edges[i].to, &b = edges[best].to;
    if (late(w) != late(b) ? late(b) : orientation(v, w, b) < 0) best = i;
  }
  return best;
}

// A closed path that visits a point again is split there into two rings.
void append_simple(std::vector<Point>& way, Rings& to) {
  std::vector<Point> again = way, path, ring;
  std::sort(again.begin(), again.end());
  std::size_t kept = 0;
  for (std::size_t i = 1; i < again.size(); ++i)
    if (again[i] == again[i - 1]) again[kept++] = again[i];
  again.resize(kept);
  if (again.empty()) return append_canonical(way, to);
  for (const Point& p : way) {
    if (std::binary_search(again.begin(), again.end(), p)) {
      const auto met = std::find(path.begin(), path.end(), p);
      ring.assign(met, path.end());
      append_canonical(ring, to);
      path.erase(met, path.end());
    }
    path.push_back(p);
  }
  append_canonical(path, to);
}

}  // namespace

void number_sides(std::vector<Subedge>& subedges) {
  std::vector<Point> events;
  for (const Subedge& p : subedges) {
    events.push_back(p.a);
    events.push_back(p.b);
  }
  std::sort(events.begin(), events.end());
  events.erase(std::unique(events.begin(), events.end()), events.end());
  std::vector<std::uint32_t> open, fresh;  // subedges that the sweep line meets, from below
  std::size_t following = 0;
  for (const Point& at : events) {
    auto here = std::partition_point(open.begin(), open.end(), [&](std::uint32_t p) {
      return orientation(subedges[p].a, subedges[p].b, at) > 0;
    });
    auto end = here;
    while (end != open.end() && subedges[*end].b == at) ++end;
    here = open.erase(here, end);
    fresh.clear();
    for (; following < subedges.size() && subedges[following].a == at; ++following)
      fresh.push_back(std::uint32_t(following));
    std::sort(fresh.begin(), fresh.end(),
              [&](std::uint32_t p, std::uint32_t q) { return lower_direction(subedges[p], subedges[q]); });
    std::array<std::int32_t, 2> sides{};
    if (here != open.begin()) {
      const Subedge& under = subedges[*(here - 1)];
      sides = {under.above(0), under.above(1)};
    }
    for (const std::uint32_t p : fresh) {
      subedges[p].below = sides;
      sides = {subedges[p].above(0), subedges[p].above(1)};
    }
    open.insert(here, fresh.begin(), fresh.end());
  }
}

Region bounded(const std::vector<Subedge>& subedges, bool (*inside)(std::int32_t, std::int32_t)) {
  std::vector<Directed> edges;
  for (const Subedge& p : subedges) {
    const bool above = inside(p.above(0), p.above(1)), below = inside(p.below[0], p.below[1]);
    if (above != below) edges.push_back(above ? Directed{p.a, p.b} : Directed{p.b, p.a});
  }
  const auto by_start = [](const Directed& p, const Directed& q) {
    return std::tie(p.from, p.to) < std::tie(q.from, q.to);
  };
  std::sort(edges.begin(), edges.end(), by_start);
  std::vector<bool> done(edges.size());
  Rings rings;
  std::vector<Point> way;
  for (std::size_t start = 0; start < edges.size(); ++start) {
    if (done[start]) continue;
    way.clear();
    for (std::size_t e = start; !done[e];) {
      done[e] = true;
      way.push_back(edges[e].from);
      const auto outs =
          std::equal_range(edges.begin(), edges.end(), Directed{edges[e].to, {}},
                           [](const Directed& p, const Directed& q) { return p.from < q.from; });
      e = next_out(edges, std::size_t(outs.first - edges.begin()), std::size_t(outs.second - edges.begin()),
                   edges[e]);
    }
    append_simple(way, rings);
  }
  return sorted(std::move(rings));
}

namespace {

Region overlay(const Rings& a, const Rings& b, bool (*inside)(std::int32_t, std::int32_t)) {
  std::vector<Subedge> subedges = snap_rounded(a, b);
  number_sides(subedges);
  return bounded(subedges, inside);
}

}  // namespace

Region region_of(const Rings& directed, std::optional<Contact>* contact) {
  const Rings rings = canonical(directed);
  std::optional<Contact> met;
  if (intersection_of(rings) != Intersection::kDisjoint)
    met = first_contact(rings);  // the location costs more
  if (contact) *contact = met;
  if (met) return overlay(rings, {}, [](std::int32_t p, std::int32_t) { return p > 0; });
  const std::vector<int> outside = windings_outside(rings);
  Region region;
  for (std::size_t r = 0; r < rings.size(); ++r) {
    const int inside = outside[r] + (twice_area(rings[r]) > 0 ? 1 : -1);
    if ((inside > 0) != (outside[r] > 0)) region.add(rings[r]);
  }
  return region;
}

Region unite(const Rings& a, const Rings& b) {
  return overlay(a, b, [](std::int32_t p, std::int32_t q) { return p > 0 || q > 0; });
}
Region subtract(const Rings& a, const Rings& b) {
  return overlay(a, b, [](std::int32_t p, std::int32_t q) { return p > 0 && q <= 0; });
}
Region common(const Rings& a, const Rings& b) {
  return overlay(a, b, [](std::int32_t p, std::int32_t q) { return p > 0 && q > 0; });
}

}  // namespace firn::geometry
