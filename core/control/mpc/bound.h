// A proof of how good a layer is: no layer of at most one droplet per cell has a smaller sum of |error| than the bound.
//
// Lagrangian decomposition: the rows whose |error| counts are cut into strips of m rows. A strip's errors depend on its
// own droplets and on those of one row above and below, so the droplets of the two rows at each cut belong to two strips.
// Each strip gets its own copy of them; copies pay lambda in the upper strip and earn it in the lower one. For any
// multipliers lambda, the sum of the strips' minima, each exact by dynamic programming (strip_kernel.h), is a lower bound;
// subgradient ascent looks for good ones [Held, Wolfe, Crowder 1974; deflected as by Camerini, Fratta, Maffioli 1975].
#pragma once

#include <vector>

#include "core/control/mpc/strip_dp.h"

namespace firn::control::mpc {

struct BoundOptions {
  int rows = 2;          ///< m, 2..4; three more times six dearer per row, and tighter
  int iterations = 500;  ///< of the ascent
  double gap = 0.0;      ///< ends when (known - bound) / known is no larger
};

struct LowerBound {
  double total_mm = 0.0;  ///< of the sum of |error|, rounding taken off
  int iterations = 0;
  int rows = 0;           ///< m
  /// The certificate: cut k lies between rows (k + 1) m - 1 and (k + 1) m; multipliers[(2 k + side) nx + i] is that of
  /// cell (i, (k + 1) m - 1 + side) [mm].
  std::vector<float> multipliers;
  std::vector<double> history_mm;  ///< best bound after each iteration
};

/// @param known_mm sum of |error| of a known layer, at which the ascent aims
/// @param problem its droplets do not matter
/// @throws std::invalid_argument: rows outside 2..4.
LowerBound lower_bound(const LayerProblem& problem, double known_mm, const BoundOptions& options,
                       const ParallelFor& parallel);

}  // namespace firn::control::mpc
