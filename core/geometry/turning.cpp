#include "core/geometry/turning.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

#include "core/geometry/planar.h"
#include "core/geometry/winding.h"

namespace firn::geometry {

std::vector<std::size_t> turn_inside_out(Rings& rings) {
  std::vector<std::size_t> turned;
  std::vector<std::int64_t> area(rings.size());
  bool any = false;
  for (std::size_t r = 0; r < rings.size(); ++r) {
    area[r] = twice_area(rings[r]);
    any = any || area[r] < 0;
  }
  if (!any) return turned;
  // For each ring those whose bounding box holds its first point: the winding number of others is 0 there.
  const auto around = rings_around_first_points(rings);
  std::vector<std::size_t> order(rings.size());
  std::iota(order.begin(), order.end(), std::size_t(0));
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return std::tuple(-std::abs(area[a]), a) < std::tuple(-std::abs(area[b]), b);
  });
  // From the largest ring to the smallest: all rings around r are decided before r.
  std::vector<bool> reversed(rings.size());
  for (const std::size_t r : order) {
    int outside = 0;          // winding number about r of the larger rings, as they are after reversal
    std::size_t nearest = r;  // the smallest ring around r; r = none
    for (const std::uint32_t o : around[r]) {
      const int turns = winding(rings[o], rings[r][0]);
      if (turns == 0 || std::abs(area[o]) < std::abs(area[r])) continue;
      outside += reversed[o] ? -turns : turns;
      if (nearest == r || std::abs(area[o]) < std::abs(area[nearest])) nearest = o;
    }
    // r is reversed with the ring that it lies in. Where it is a hole afterwards (clockwise) and there is no
    // material around it (winding number 0 or less), it is inside out by itself.
    reversed[r] = nearest != r && reversed[nearest];
    const bool clockwise = (area[r] < 0) != reversed[r];
    if (clockwise && outside <= 0) reversed[r] = !reversed[r];
  }
  // The first point stays: it is the least one of a canonical ring.
  for (std::size_t r = 0; r < rings.size(); ++r)
    if (reversed[r]) {
      const std::size_t begin = r ? rings.ends[r - 1] : 0;
      std::reverse(rings.points.begin() + std::ptrdiff_t(begin) + 1,
                   rings.points.begin() + std::ptrdiff_t(rings.ends[r]));
      turned.push_back(r);
    }
  return turned;
}

}  // namespace firn::geometry
