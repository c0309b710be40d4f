#include "core/geometry/intersection.h"

#include <bit>
#include <numeric>

namespace firn::geometry {
namespace {

int side(Point a, Point b, Point p) {
  const std::int64_t s = (std::int64_t(b.x) - a.x) * (std::int64_t(p.y) - a.y) -
                         (std::int64_t(b.y) - a.y) * (std::int64_t(p.x) - a.x);
  return (s > 0) - (s < 0);
}

bool in_bounds(Point a, Point b, Point p) {  // p is on the line through a and b
  return std::min(a.x, b.x) <= p.x && p.x <= std::max(a.x, b.x) && std::min(a.y, b.y) <= p.y &&
         p.y <= std::max(a.y, b.y);
}

Intersection of_segments(Point a, Point b, Point c, Point d) {
  const int c_side = side(a, b, c), d_side = side(a, b, d);
  if (c_side * d_side > 0) return Intersection::kDisjoint;
  const int a_side = side(c, d, a), b_side = side(c, d, b);
  if (a_side * b_side > 0) return Intersection::kDisjoint;
  if (c_side * d_side < 0 && a_side * b_side < 0) return Intersection::kCrossing;
  const bool touch = (!c_side && in_bounds(a, b, c)) || (!d_side && in_bounds(a, b, d)) ||
                     (!a_side && in_bounds(c, d, a)) || (!b_side && in_bounds(c, d, b));
  return touch ? Intersection::kTouching : Intersection::kDisjoint;
}

struct Edges {
  const Point* points;
  const std::uint32_t* next;
  double grown;
  Point from(std::size_t i) const { return points[i]; }
  Point to(std::size_t i) const { return points[next[i]]; }
  PairBox bent(std::size_t i) const { return PairBox::of(from(i), to(i)); }
};

}  // namespace

// Adds the monotone chains of one ring.
void IntersectionCheck::add_chains(const Point* points, std::uint32_t begin, std::uint32_t end) {
  static_assert(MonotoneChains::kXFalls == 1 && MonotoneChains::kYFalls == 2);
  next_[end - 1] = begin;
  int last = MonotoneChains::kNone;
  const auto add = [&](std::uint32_t edge, int run) {
    if (MonotoneChains::begins(run, last)) chains_.begin(edge, run, last);
    last = run;
  };
  std::uint32_t i = begin;
  const auto add_one = [&] {
    const Point from = points[i], to = points[next_[i]];
    add(i++, int(to.x < from.x) | int(to.y < from.y) << 1);
  };
  add_one();
  for (; i + 4 < end; i += 4) {
    const unsigned runs = signs(two_points(points + i + 1) < two_points(points + i)) |
                          signs(two_points(points + i + 3) < two_points(points + i + 2)) << 4;
    const unsigned turns = runs ^ (runs << 2 | unsigned(last));
    for (unsigned turned = (turns | turns >> 1) & 0x55; turned; turned &= turned - 1) {
      const int k = std::countr_zero(turned);
      add(i + std::uint32_t(k / 2), int(runs >> k & 3));
    }
  }
  while (i < end) add_one();
}

Intersection intersection_of(const Rings& rings) { return IntersectionCheck()(rings); }

Intersection IntersectionCheck::operator()(const Rings& rings, double within) {
  facing_.clear();
  next_.resize(rings.points.size());
  std::iota(next_.begin(), next_.end(), 1u);
  const std::uint32_t* const next = next_.data();
  chains_.clear();
  std::uint32_t begin = 0;
  for (const std::uint32_t end : rings.ends) {
    if (end > begin) add_chains(rings.points.data(), begin, end);
    begin = end;
  }
  chains_.end(std::uint32_t(rings.points.size()));
  Intersection worst = Intersection::kDisjoint;
  chains_.pairs(Edges{rings.points.data(), next, 0.5 * within}, [&](std::size_t i, std::size_t j) {
    const Point a = rings.points[i], b = rings.points[next[i]], c = rings.points[j],
                d = rings.points[next[j]];
    if (next[i] == j || next[j] == i) {
      // Neighbours share a corner. They share more only if one runs back along the other.
      const Point p = next[i] == j ? a : c, corner = next[i] == j ? b : d, q = next[i] == j ? d : b;
      const bool back = (std::int64_t(p.x) - corner.x) * (std::int64_t(q.x) - corner.x) +
                                (std::int64_t(p.y) - corner.y) * (std::int64_t(q.y) - corner.y) >
                            0 &&
                        side(p, corner, q) == 0;
      if (back && worst == Intersection::kDisjoint) {
        worst = Intersection::kTouching;
        met_ = std::uint32_t(i);
      }
      return;
    }
    const Intersection m = of_segments(a, b, c, d);
    if (int(m) > int(worst)) {
      worst = m;
      met_ = std::uint32_t(i);
    }
    if (within > 0 && dot(to_vec(b) - to_vec(a), to_vec(d) - to_vec(c)) < 0)
      facing_.push_back({std::uint32_t(i), std::uint32_t(j)});
  });
  return worst;
}

}  // namespace firn::geometry
