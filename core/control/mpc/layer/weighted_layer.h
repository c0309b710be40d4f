// weighted_layer() computes a layer of at most one droplet per cell for any alpha of Eq. (8) [Lu 2015], N =
// 1: it minimises alpha mean|e| + (1 - alpha) std(e) over the cells that count.
//
// The deviation couples all cells; but std(e) <= (s + mean (e - m)^2 / s) / 2 for any m and s > 0, with
// equality at the present layer for its mean m and deviation s. The right side is a sum over cells, which
// strips minimise exactly (strip_dp.h). A decrease of the sum is a decrease of the objective. Then m and s
// are updated, until the objective stays (majorise, minimise).
#pragma once

#include "core/control/mpc/layer/layer_problem.h"
#include "core/grid/parallel.h"

namespace firn::control::mpc {

struct ErrorMoments {
  double absolute_mm = 0.0, mean_mm = 0.0, deviation_mm = 0.0;  ///< mean|e|, mean(e), std(e)
};
ErrorMoments error_moments(
    const LayerProblem& problem);  ///< of the present droplets, over the cells that count

/// alpha mean|e| + (1 - alpha) std(e) of the present droplets [mm], in double precision.
double weighted_objective_mm(const LayerProblem& problem, double alpha);

struct WeightedOptions {
  int strip_rows = 3;  ///< strips of 2 up to this many rows
  int rounds = 30;     ///< majorisations per start, at most
};

/// Starts from the droplets that the problem holds, from none, from all and from the layer for alpha = 1, and
/// leaves the best layer found: no worse than any of the four. @returns its objective [mm] @pre 0 < alpha <=
/// 1
double weighted_layer(LayerProblem& problem, double alpha, const WeightedOptions& options,
                      const ParallelFor& parallel);

}  // namespace firn::control::mpc
