#include "core/control/mpc/bound.h"

#include "core/control/mpc/bound_checker.h"
#include "core/control/mpc/decomposition.h"

namespace firn::control::mpc {

LowerBound lower_bound(const Setup& setup, const HeightMap& height, const MaterialMap& materials, double known_mm,
                       const BoundOptions& o, const ParallelFor& parallel, const std::function<void(double)>& watch) {
  constexpr std::size_t kPatience = 10;
  const LayerProblem problem(setup, height, materials);
  Decomposition split(problem, o.rows);
  LowerBound found;
  found.rows = o.rows;
  for (; found.sweeps < o.sweeps; ++found.sweeps) {
    const double now = split.sweep(found.sweeps % 2 == 0 ? Way::kDown : Way::kUp, parallel);
    found.history_mm.push_back(now);
    if (watch) watch(now);
    if (known_mm > 0.0 && known_mm - now <= o.gap * known_mm) {
      ++found.sweeps;
      break;
    }
    if (const std::size_t n = found.history_mm.size(); n > kPatience && now - found.history_mm[n - 1 - kPatience] < o.stall * now) {
      ++found.sweeps;
      break;
    }
  }
  found.multipliers = split.multipliers();
  found.total_mm = certified_bound_mm(setup, height, materials, o.rows, found.multipliers);
  return found;
}

}  // namespace firn::control::mpc
