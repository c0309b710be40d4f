// sweep_strips() computes a layer by strip dynamic programming: with everything outside a strip of k rows
// fixed, the optimal droplets of the strip are found exactly, since a droplet affects only its neighbours.
// States are pairs of neighbouring columns
// (4^k), moves add one (8^k), so a strip costs 8^k (k + 2) |e| per column. Overlapping strips are swept until
// no strip improves.
#pragma once

#include <cstdint>

#include "core/control/mpc/layer/cell_cost.h"
#include "core/control/mpc/layer/layer_problem.h"
#include "core/grid/parallel.h"

namespace firn::control::mpc {

struct StripOptions {
  int rows = 2;          ///< k, 1..6
  int max_sweeps = 100;  ///< a sweep visits every strip that may still improve
  CellCost cost = {};    ///< of which the sum is lowered
};

struct StripResult {
  int sweeps = 0;
  std::int64_t strips = 0;    ///< solved
  std::int64_t improved = 0;  ///< of them
  bool settled = false;       ///< no strip of k rows can be improved
};

/// Sweeps strips of options.rows rows over the problem, from the droplets it holds. Strips of one class
/// (first row modulo k + 2) do not touch each other and may run at the same time: same bytes for any number
/// of threads. The objective never rises. @throws std::invalid_argument: rows outside 1..6.
StripResult sweep_strips(LayerProblem& problem, const StripOptions& options, const ParallelFor& parallel);

}  // namespace firn::control::mpc
