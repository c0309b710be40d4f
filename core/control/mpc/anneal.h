// anneal() improves the plan of a horizon by simulated annealing. Layers are coupled through sat(), so that
// two of them can reach almost any height where one cannot, but only by droplets that pay together
// [Kirkpatrick, Gelatt, Vecchi 1983; Metropolis et al. 1953].
#pragma once

#include <cstdint>
#include <span>

#include "core/control/mpc/greedy.h"
#include "core/control/mpc/horizon_state.h"
#include "core/control/mpc/objective.h"
#include "core/grid/random.h"

namespace firn::control::mpc {

struct AnnealOptions {
  int layers = 1;           ///< the first so many of the horizon are changed
  int sweeps = 100;         ///< each tries one change on every cell in every layer
  double hot_mm = 0.5e-3;   ///< temperature at the start, of the sum of |error| (a cell's worth),
  double cold_mm = 0.1e-3;  ///< and at the end
  std::int64_t max_evaluations = 0;
};

/// Changes the plan in `objective` by single droplets on `cells`, in raster order, layer by layer: one that
/// worsens the objective by d is kept with probability exp(-d / T) (T falls as a parabola of the sweeps; the
/// logarithm comes from a table of 1024, computed with + - * / alone: same bytes everywhere). May end worse
/// than it began: keep a copy.
SearchResult anneal(HorizonObjective& objective, std::span<const std::uint32_t> cells,
                    const AnnealOptions& options, RandomStream& random);

/// The same on a plan in single precision, several times faster.
SearchResult anneal(HorizonState& field, const PlanCost& cost, std::span<const std::uint32_t> cells,
                    const AnnealOptions& options, RandomStream& random);

}  // namespace firn::control::mpc
