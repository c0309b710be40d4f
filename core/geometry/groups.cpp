#include "core/geometry/groups.h"

#include <algorithm>
#include <limits>

#include "core/geometry/planar.h"
#include "core/geometry/point_measures.h"
#include "core/geometry/rtree.h"
#include "core/geometry/winding.h"

namespace firn::geometry {

std::vector<std::vector<std::uint32_t>> nested_groups(const Region& region) {
  std::vector<std::int64_t> areas(region.size());
  std::vector<std::vector<std::uint32_t>> groups;
  for (std::uint32_t r = 0; r < region.size(); ++r) {
    areas[r] = twice_area(region[r]);
    if (areas[r] > 0) groups.push_back({r});
  }
  if (groups.size() == region.size()) return groups;
  StaticRTree boxes;
  boxes.resize(groups.size());
  for (std::size_t g = 0; g < groups.size(); ++g) boxes.set(g, box_of(region[groups[g][0]]));
  boxes.build();
  constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
  for (std::uint32_t r = 0; r < region.size(); ++r) {
    if (areas[r] >= 0) continue;
    std::size_t around = kNone;  // the smallest outer ring about the hole; of equal ones the first
    boxes.touching(box_of(region[r]), [&](std::size_t g) {
      const std::uint32_t outer = groups[g][0];
      if (areas[outer] <= -areas[r] || (around != kNone && areas[outer] >= areas[groups[around][0]])) return;
      // A hole may touch its outer ring at a point, so the majority of its corners decides.
      const std::size_t step = std::max<std::size_t>(1, region[r].size() / 5),
                        asked = (region[r].size() + step - 1) / step;
      std::size_t inside = 0;
      for (std::size_t i = 0; i < asked && 2 * inside <= asked; ++i)
        inside += winding(region[outer], region[r][i * step]) != 0;
      if (2 * inside > asked) around = g;
    });
    if (around != kNone) groups[around].push_back(r);
  }
  return groups;
}

}  // namespace firn::geometry
