#include "procs/scheduler/pass_list.h"

#include <algorithm>
#include <array>

#include "core/grid/sub_patterns.h"

namespace firn {

bool fires(const Pass& p, const DropletPattern& plan, const MaterialMap& materials, int sub_patterns, int i,
           int j) {
  const std::size_t cell = plan.spec.index(i, j);
  return plan.cells[cell] > p.round && sub_pattern_of(i, j, sub_patterns) == p.sub_pattern &&
         (materials.cells.empty() ? Material::kA : materials.of(cell)) == p.material;
}

std::vector<Pass> passes_of(const DropletPattern& plan, const MaterialMap& materials, int sub_patterns) {
  // Maximum number of droplets of any cell of a sub-pattern and ink: the number of rounds.
  std::array<std::array<int, 2>, 4> rounds{};
  for (int j = 0; j < plan.spec.ny; ++j)
    for (int i = 0; i < plan.spec.nx; ++i) {
      const std::size_t cell = plan.spec.index(i, j);
      const bool b = !materials.cells.empty() && materials.of(cell) == Material::kB;
      int& most = rounds[std::size_t(sub_pattern_of(i, j, sub_patterns))][b];
      most = std::max(most, int(plan.cells[cell]));
    }
  std::vector<Pass> passes;
  for (int round = 0; round < plan.passes(); ++round)
    for (int s = 0; s < sub_patterns; ++s) {
      const auto [a, b] = rounds[std::size_t(s)];
      if (a > round) passes.push_back({round, s, Material::kA, b <= round});
      if (b > round) passes.push_back({round, s, Material::kB, true});
    }
  return passes;
}

}  // namespace firn
