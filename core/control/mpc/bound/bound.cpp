#include "core/control/mpc/bound/bound.h"

#include <cmath>

#include "core/control/mpc/bound/bound_checker.h"

namespace firn::control::mpc {

std::vector<double> raise_bound(DualDecomposition& split, double known_mm, const BoundOptions& o,
                                const ParallelFor& parallel, const std::function<void(double)>& watch) {
  constexpr std::size_t kPatience = 10;
  std::vector<double> history_mm;
  while (int(history_mm.size()) < o.sweeps) {
    const double now =
        split.sweep(history_mm.size() % 2 == 0 ? SweepDirection::kDown : SweepDirection::kUp, parallel);
    history_mm.push_back(now);
    if (watch) watch(now);
    if (known_mm > 0.0 && known_mm - now <= o.gap * known_mm) break;
    if (const std::size_t n = history_mm.size();
        n > kPatience && now - history_mm[n - 1 - kPatience] < o.stall * std::abs(now))
      break;
  }
  return history_mm;
}

LowerBound lower_bound(const Setup& setup, const HeightMap& height, const MaterialMap& materials,
                       double known_mm, const BoundOptions& o, const ParallelFor& parallel,
                       const std::function<void(double)>& watch) {
  const LayerProblem problem(setup, height, materials);
  DualDecomposition split(problem, o.rows, o.cost);
  LowerBound found;
  found.rows = o.rows;
  found.history_mm = raise_bound(split, known_mm, o, parallel, watch);
  found.sweeps = int(found.history_mm.size());
  found.multipliers = split.multipliers();
  found.total_mm = certified_bound_mm(setup, height, materials, o.rows, found.multipliers, o.cost);
  return found;
}

}  // namespace firn::control::mpc
