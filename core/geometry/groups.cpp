#include "core/geometry/groups.h"

#include <algorithm>
#include <span>

#include "core/geometry/box.h"
#include "core/geometry/planar.h"
#include "core/geometry/point_measures.h"
#include "core/geometry/winding.h"

namespace firn::slice {

std::vector<std::vector<std::uint32_t>> nested_groups(const Region& region) {
  struct Outer {
    std::int64_t area;
    std::size_t group;
    BoxOf<std::int32_t> box;
  };
  std::vector<std::int64_t> areas(region.size());
  std::vector<std::vector<std::uint32_t>> groups;
  for (std::uint32_t r = 0; r < region.size(); ++r) {
    areas[r] = twice_area(region[r]);
    if (areas[r] > 0) groups.push_back({r});
  }
  if (groups.size() == region.size()) return groups;
  std::vector<Outer> outers;
  for (std::size_t g = 0; g < groups.size(); ++g)
    outers.push_back({areas[groups[g][0]], g, box_of(region[groups[g][0]])});
  std::stable_sort(outers.begin(), outers.end(),
                   [](const Outer& a, const Outer& b) { return a.area < b.area; });
  for (std::uint32_t r = 0; r < region.size(); ++r) {
    if (areas[r] >= 0) continue;
    const BoxOf<std::int32_t> box = box_of(region[r]);
    for (const Outer& outer : outers) {
      if (outer.area <= -areas[r] || !outer.box.meets(box)) continue;
      const auto ring = region[groups[outer.group][0]];
      // A hole may touch its outer ring at a point, so the majority of its corners decides.
      const std::size_t step = std::max<std::size_t>(1, region[r].size() / 5),
                        asked = (region[r].size() + step - 1) / step;
      std::size_t inside = 0;
      for (std::size_t i = 0; i < asked && 2 * inside <= asked; ++i)
        inside += winding(ring, region[r][i * step]) != 0;
      if (2 * inside > asked) {
        groups[outer.group].push_back(r);
        break;
      }
    }
  }
  return groups;
}

}  // namespace firn::slice
