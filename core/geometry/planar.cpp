#include "core/geometry/planar.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/geometry/exact.h"
#include "core/geometry/winding.h"

namespace firn::slice {

std::int64_t twice_area(std::span<const Point> ring) {
  if (ring.empty()) return 0;
  const Point o =
      ring[0];  // terms of 63 bits may wrap; the sum, below 2^63 for any ring within kMaxUnits, does not
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
    // A ray to the left, just above the point; edges count where they pass its height.
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

Boxes::Boxes(const Rings& rings) : boxes_(rings.size()) {
  for (std::size_t r = 0; r < rings.size(); ++r) {
    Box& box = boxes_[r];
    box.low = box.high = rings[r][0];
    for (const Point& p : rings[r]) {
      box.low = {std::min(box.low.x, p.x), std::min(box.low.y, p.y)};
      box.high = {std::max(box.high.x, p.x), std::max(box.high.y, p.y)};
    }
  }
}

std::vector<std::vector<std::uint32_t>> Boxes::around_first_points(const Rings& rings) const {
  std::vector<std::uint32_t> order(boxes_.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::pair(boxes_[a].low.x, a) < std::pair(boxes_[b].low.x, b);
  });
  // Rings by where they begin on x; those that ended before are taken off the list of open ones on the way.
  std::vector<std::vector<std::uint32_t>> around(boxes_.size());
  std::vector<std::uint32_t> open;
  for (const std::uint32_t r : order) {
    const Point at = rings[r][0];
    std::erase_if(open, [&](std::uint32_t o) { return boxes_[o].high.x < boxes_[r].low.x; });
    for (const std::uint32_t o : open)
      if (boxes_[o].low.y <= at.y && at.y <= boxes_[o].high.y && boxes_[o].high.x >= at.x)
        around[r].push_back(o);
    open.push_back(r);
  }
  return around;
}

std::vector<int> windings_outside(const Rings& rings) {
  std::vector<int> outside(rings.size());
  if (rings.size() < 2) return outside;
  const auto around = Boxes(rings).around_first_points(rings);
  for (std::size_t r = 0; r < rings.size(); ++r)
    for (const std::uint32_t o : around[r]) outside[r] += winding(rings[o], rings[r][0]);
  return outside;
}

std::vector<Nest> nesting(const Rings& region) {
  std::vector<Nest> nests(region.size());
  if (region.size() < 2) return nests;
  const auto around = Boxes(region).around_first_points(region);
  std::vector<std::int64_t> size(region.size());
  for (std::size_t r = 0; r < region.size(); ++r) size[r] = std::abs(twice_area(region[r]));
  for (std::size_t r = 0; r < region.size(); ++r)
    for (const std::uint32_t o : around[r])
      if (winding(region[o], region[r][0]) != 0) {
        ++nests[r].depth;
        if (nests[r].parent < 0 || size[o] < size[std::size_t(nests[r].parent)])
          nests[r].parent = std::int32_t(o);
      }
  return nests;
}

}  // namespace firn::slice
