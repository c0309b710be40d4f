// search_horizon() computes a plan of several layers: strips layer by layer, annealing over all of them,
// descent.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/control/mpc/greedy.h"
#include "core/control/mpc/layer/strip_dp.h"
#include "core/control/mpc/objective.h"

namespace firn::control::mpc {

struct HorizonOptions {
  int strip_rows = 3;
  int anneal_sweeps = 100;           ///< 0: none
  std::int64_t max_evaluations = 0;  ///< of single-droplet changes, together
  ParallelFor parallel = serially;   ///< for the strips
};

/// The state that a search over layers starts from.
struct HorizonStart {
  const Setup& setup;
  const HeightMap& height;                 ///< finite everywhere
  std::span<const MaterialMap> materials;  ///< per layer of the horizon; maps without cells: one ink
  double outside_price = 0.0;              ///< PlanCost
};

/// Returns a start plan: the number of droplets that the missing height requires in `layers` layers, by error
/// diffusion, the partial layer first. The full layers after it level its surface, so this is a far better
/// start than the reverse.
std::vector<DropletPattern> partial_layer_first(const HorizonStart& state, int layers);

/// Layer `n` of the plan on the surface that those before it leave, by strips of 2 .. rows rows (alpha = 1
/// [Lu 2015, Eq. (8)]): the sum of |error| after it never rises. @pre at most one droplet per cell
StripResult strips_of_layer(std::vector<DropletPattern>& plan, int n, const HorizonStart& state, int rows,
                            const ParallelFor& parallel = serially);

/// Improves the plan in `objective`, whose surface is the state's and whose layers after the first are empty.
/// First over its first layer, then over two, up to the horizon: of the best plan so far and strips of the
/// new layer, and the layers with the partial one first, each after descent, the best is annealed where
/// anything may be gained, descends again and goes on if it is better. The objective never rises, and with
/// the same numbers a longer horizon ends no worse than a shorter one, whose work it repeats before its own.
SearchResult search_horizon(HorizonObjective& objective, const HorizonStart& state,
                            const HorizonOptions& options, RandomStream& random);

}  // namespace firn::control::mpc
