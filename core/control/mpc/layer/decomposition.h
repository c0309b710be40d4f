// One layer's problem split into strips that agree with their neighbours on windows of droplets.
//
// The rows whose cost counts are cut into strips of m. A strip's costs depend on its own droplets and on
// those of one row above and below, so the droplets of the two rows at each cut belong to two strips, each of
// which has its own copy. For every window of these two rows and three columns a function of its 64 patterns
// is added to the upper strip and taken from the lower: whatever the functions are, a layer, whose copies
// agree, costs what it costs, so that the sum of the strips' minima, exact by dynamic programming
// (window_kernel.h), is a lower bound for every layer. Functions are found by passing on min-marginals, not
// by subgradients: a strip visited on the way down gives all that it knows of its lower cut's windows, one
// after the other, to the strip below, and on the way up to the one above [as sequential reweighted message
// passing does on graphs: Kolmogorov 2006; Tourani et al. 2018, "MPLP++"]. The strip's own minimum does not
// change by that, its neighbour's cannot fall: the bound never falls, and mostly stops within ten sweeps. The
// strips then know of each other, so that deciding them one after the other gives a layer near the optimum.
#pragma once

#include <vector>

#include "core/control/mpc/layer/layer_problem.h"
#include "core/control/mpc/layer/window_kernel.h"
#include "core/grid/parallel.h"

namespace firn::control::mpc {

enum class Way { kDown, kUp };

class Decomposition {
 public:
  /// 256 / m bytes per cell. @param rows m, 1..4. @throws std::invalid_argument: another number
  /// @param problem its droplets do not matter
  Decomposition(const LayerProblem& problem, int rows, const CellCost& cost = {});

  /// The multipliers stay: they prove something of any cost, and much of one that is alike.
  void set_cost(const CellCost& cost) { cost_ = cost; }

  /// Visits every strip once, passing everything on downwards or upwards. Groups of strips run at the same
  /// time, the same groups for any number of threads. @returns the sum of the strips' minima, the bound up to
  /// rounding
  double sweep(Way way, const ParallelFor& parallel);

  /// Decides strip after strip, each best for what is known of those to come: well after a sweep the other
  /// way. Sets the droplets of `layer`, a problem like the one split.
  void decide(Way way, LayerProblem& layer) const;

  int rows() const { return rows_; }
  /// Cut k lies between rows (k + 1) m - 1 and (k + 1) m. multipliers()[(k nx + i) 64 + pattern] is added to
  /// the strip above for the droplets of these rows (lower row: bit 0) in columns i - 1, i, i + 1: west * 16
  /// + middle * 4 + east.
  const std::vector<float>& multipliers() const { return shared_; }

 private:
  struct Work;  // of one visit
  int first_row(int s) const { return s * rows_ - 1; }
  int high() const { return rows_ + 2; }
  const float* shared(int cut, int x) const {
    return shared_.data() + (std::size_t(cut) * std::size_t(nx_) + std::size_t(x)) * kSharedPatterns;
  }
  void fill_tables(int s, Work& work) const;
  double visit(int s, Way way, Work& work);

  LayerProblem bare_;
  int rows_, nx_, ny_, strips_;
  CellCost cost_;
  std::vector<float> shared_;
};

}  // namespace firn::control::mpc
