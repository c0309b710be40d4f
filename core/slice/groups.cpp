#include "core/slice/groups.h"

#include <algorithm>
#include <span>

#include "core/slice/box_pairs.h"

namespace firn::slice {
namespace {

double doubled_area(std::span<const Point> ring) {
  double sum = 0;
  for (std::size_t i = 1; i + 1 < ring.size(); ++i) {
    const std::int64_t ax = std::int64_t(ring[i].x) - ring[0].x, ay = std::int64_t(ring[i].y) - ring[0].y;
    const std::int64_t bx = std::int64_t(ring[i + 1].x) - ring[0].x, by = std::int64_t(ring[i + 1].y) - ring[0].y;
    sum += double(ax * by - ay * bx);
  }
  return sum;
}

int winding(std::span<const Point> ring, Point p) {
  int turns = 0;
  Point a = ring.back();
  for (const Point b : ring) {
    if ((a.y <= p.y) != (b.y <= p.y)) {
      const std::int64_t side = (std::int64_t(b.x) - a.x) * (std::int64_t(p.y) - a.y) -
                                (std::int64_t(p.x) - a.x) * (std::int64_t(b.y) - a.y);
      if (b.y > a.y) turns += side > 0;
      else turns -= side < 0;
    }
    a = b;
  }
  return turns;
}

}  // namespace

std::vector<std::vector<std::uint32_t>> nested_groups(const Region& region) {
  struct Outer {
    double area;
    std::size_t group;
    BoxOf<std::int32_t> box;
  };
  std::vector<std::vector<std::uint32_t>> groups;
  std::vector<Outer> outers;
  for (std::uint32_t r = 0; r < region.size(); ++r) {
    const double area = doubled_area(region[r]);
    if (area <= 0) continue;
    BoxOf<std::int32_t> box;
    for (const Point p : region[r]) box.add(p.x, p.y);
    outers.push_back({area, groups.size(), box});
    groups.push_back({r});
  }
  if (groups.size() == region.size()) return groups;
  std::stable_sort(outers.begin(), outers.end(), [](const Outer& a, const Outer& b) { return a.area < b.area; });
  for (std::uint32_t r = 0; r < region.size(); ++r) {
    const double area = doubled_area(region[r]);
    if (area >= 0) continue;
    BoxOf<std::int32_t> box;
    for (const Point p : region[r]) box.add(p.x, p.y);
    for (const Outer& outer : outers) {
      if (outer.area <= -area || !outer.box.meets(box)) continue;
      const auto ring = region[groups[outer.group][0]];
      // A hole may touch its outer ring at a point: most of its corners decide.
      std::size_t inside = 0, asked = 0;
      const std::size_t step = std::max<std::size_t>(1, region[r].size() / 5);
      for (std::size_t i = 0; i < region[r].size(); i += step, ++asked) inside += winding(ring, region[r][i]) != 0;
      if (2 * inside > asked) {
        groups[outer.group].push_back(r);
        break;
      }
    }
  }
  return groups;
}

}  // namespace firn::slice
