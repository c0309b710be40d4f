#include "procs/scheduler/pass_list.h"

#include <algorithm>
#include <array>

#include "core/grid/sub_patterns.h"

namespace firn {

bool fires(const Pass& p, const DropletPattern& plan, const MaterialMap& materials, int sub_patterns, int i,
           int j, const Placement& placement) {
  const std::size_t cell = plan.spec.index(i, j);
  return plan.cells[cell] > p.round && sub_pattern_of(i, j, sub_patterns) == p.sub_pattern &&
         (materials.cells.empty() ? Material::kA : materials.of(cell)) == p.material &&
         placement.small(cell) == p.small;
}

std::vector<Pass> passes_of(const DropletPattern& plan, const MaterialMap& materials, int sub_patterns,
                            const Placement& placement) {
  // Maximum number of droplets of any cell of a sub-pattern, ink and size: the number of rounds.
  std::array<std::array<int, 4>, 4> rounds{};
  for (int j = 0; j < plan.spec.ny; ++j)
    for (int i = 0; i < plan.spec.nx; ++i) {
      const std::size_t cell = plan.spec.index(i, j);
      const bool b = !materials.cells.empty() && materials.of(cell) == Material::kB;
      int& most = rounds[std::size_t(sub_pattern_of(i, j, sub_patterns))]
                        [std::size_t(2 * int(b) + int(placement.small(cell)))];
      most = std::max(most, int(plan.cells[cell]));
    }
  std::vector<Pass> passes;
  for (int round = 0; round < plan.passes(); ++round)
    for (int s = 0; s < sub_patterns; ++s) {
      const std::size_t before = passes.size();
      for (int kind = 0; kind < 4; ++kind)
        if (rounds[std::size_t(s)][std::size_t(kind)] > round)
          passes.push_back({round, s, kind < 2 ? Material::kA : Material::kB, kind % 2 == 1, false});
      if (passes.size() > before) passes.back().cure = true;
    }
  return passes;
}

}  // namespace firn
