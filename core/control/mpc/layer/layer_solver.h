// solve_layer() computes a layer of at most one droplet per cell, alpha = 1, near the optimum, and a lower
// bound of the optimum.
#pragma once

#include <functional>

#include "core/control/mpc/layer/dual_decomposition.h"
#include "core/control/mpc/layer/layer_problem.h"
#include "core/grid/parallel.h"

namespace firn::control::mpc {

struct LayerSolverOptions {
  int polish_rows = 3;  ///< strips of 2 up to this many rows improve the layer found (strip_dp.h), 2..6
  int bound_rows = 1;   ///< m of the decomposition, 1..4
  int sweeps = 2;       ///< of the decomposition, down, up, down, ...; 0: strips only
  double gap = 1e-6;    ///< ends when (found - bound) / found is no larger
  CellCost cost = {};   ///< of which the sum is lowered and bounded
};

struct LayerSolution {
  double found_mm = 0.0;        ///< sum of |error|, or of the cells' costs, of the problem's droplets now
  double lower_bound_mm = 0.0;  ///< of the sum of any layer, up to rounding in single precision (bound.h
                                ///< proves); 0 without sweeps
  int sweeps = 0;
  std::int64_t strips = 0;  ///< solved by sweep_strips
};

/// Improves the droplets that the problem holds. Each sweep of the decomposition is followed by a decision of
/// all strips the other way; strips polish it, and where it differs from the best layer so far, every patch
/// of differing cells that do not touch others' errors is evaluated by itself. The objective never rises.
/// Same bytes for any number of threads. @throws std::invalid_argument: rows
/// @param watch called after the first strips, each sweep and each decision; may be empty
LayerSolution solve_layer(LayerProblem& problem, const LayerSolverOptions& options,
                          const ParallelFor& parallel,
                          const std::function<void(const LayerSolution&)>& watch = {});

/// Gives `layer` the droplets of `other`, patch by patch, where these are better. @returns patches taken
/// @param other the same problem with other droplets
int take_better_patches(LayerProblem& layer, const LayerProblem& other, const CellCost& cost = {});

/// Sum of the cells' costs, in double precision and a fixed order.
double total_cost(const LayerProblem& layer, const CellCost& cost);

}  // namespace firn::control::mpc
