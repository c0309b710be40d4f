#include "core/geometry/planar.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/geometry/exact.h"
#include "core/geometry/rtree.h"
#include "core/geometry/winding.h"

namespace firn::geometry {

std::int64_t twice_area(std::span<const Point> ring) {
  if (ring.empty()) return 0;
  // Terms of 63 bits may wrap. The sum does not: it is below 2^63 for any ring within kMaxUnits.
  const Point o = ring[0];
  std::uint64_t sum = 0;
  for (std::size_t i = 1; i + 1 < ring.size(); ++i)
    sum += std::uint64_t(orientation(o, ring[i], ring[i + 1]));
  return std::int64_t(sum);
}

double area_mm2(const Rings& rings) {
  double sum = 0.0;
  for (std::size_t r = 0; r < rings.size(); ++r) sum += 0.5 * double(twice_area(rings[r]));
  return sum * (kMmPerUnit * kMmPerUnit);
}

int winding(std::span<const Point> ring, Point at) {
  int turns = 0;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Point &p = ring[i], &q = ring[i + 1 < ring.size() ? i + 1 : 0];
    // The ray runs to the left, just above the point; edges count where they pass its height.
    if (p.y <= at.y && q.y > at.y) {
      if (orientation(p, q, at) <= 0) --turns;
    } else if (p.y > at.y && q.y <= at.y) {
      if (orientation(p, q, at) >= 0) ++turns;
    }
  }
  return turns;
}

int winding(const Rings& rings, Point at) {
  int turns = 0;
  for (std::size_t r = 0; r < rings.size(); ++r) turns += winding(rings[r], at);
  return turns;
}

std::vector<std::vector<std::uint32_t>> rings_around_first_points(const Rings& rings) {
  std::vector<BoxOf<std::int32_t>> boxes(rings.size());
  StaticRTree tree;
  tree.resize(rings.size());
  for (std::size_t r = 0; r < rings.size(); ++r) {
    for (const Point& p : rings[r]) boxes[r].add(p.x, p.y);
    tree.set(r, boxes[r]);
  }
  tree.build();
  const auto begins_before = [&](std::size_t a, std::size_t b) {
    return std::pair(boxes[a].x0, a) < std::pair(boxes[b].x0, b);
  };
  std::vector<std::vector<std::uint32_t>> around(rings.size());
  for (std::size_t r = 0; r < rings.size(); ++r) {
    const Point at = rings[r][0];
    tree.touching({at.x, at.y, at.x, at.y}, [&](std::size_t o) {
      if (begins_before(o, r)) around[r].push_back(std::uint32_t(o));
    });
    std::sort(around[r].begin(), around[r].end(), begins_before);
  }
  return around;
}

std::vector<int> windings_outside(const Rings& rings) {
  std::vector<int> outside(rings.size());
  if (rings.size() < 2) return outside;
  const auto around = rings_around_first_points(rings);
  for (std::size_t r = 0; r < rings.size(); ++r)
    for (const std::uint32_t o : around[r]) outside[r] += winding(rings[o], rings[r][0]);
  return outside;
}

}  // namespace firn::geometry
