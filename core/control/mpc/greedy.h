// greedy_search() computes a locally optimal plan by the paper's stochastic greedy search [Lu 2015, IV-C] on
// the incremental objective.
#pragma once

#include <cstdint>

#include "core/control/mpc/objective.h"
#include "core/grid/random.h"

namespace firn::control::mpc {

struct SearchLimits {
  int subset = 16;                   ///< M
  std::int64_t max_evaluations = 0;  ///< of the objective, together
};

struct SearchResult {
  std::int64_t evaluations = 0;
  std::int64_t moves = 0;  ///< single-droplet changes kept
  bool optimal = false;    ///< no single-droplet change anywhere in the horizon improves
};

/// Smallest improvement that counts [mm of objective]; below it lies rounding.
inline constexpr double kMinGain_mm = 1e-13;

/// Improves the plan in `objective` until no single-droplet change on a cell of the mask, in any layer of the
/// horizon, lowers it by more than kMinGain_mm, or the evaluations are used up. Points (cell, layer) are
/// taken in random subsets of M, each sweep without replacement; above 32,768 points, of one block of so many
/// neighbouring points after the other, since memory is slow. As the paper has it, all points of a subset
/// are tried against the same plan and all that improve are changed together; that can raise the objective
/// (errata on IV-C), and then they are changed one after the other, each only if it still improves. The
/// objective therefore never rises. The last sweep starts from freshly computed sums.
SearchResult greedy_search(HorizonObjective& objective, const SearchLimits& limits, RandomStream& random);

}  // namespace firn::control::mpc
