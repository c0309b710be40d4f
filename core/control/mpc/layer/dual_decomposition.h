// DualDecomposition computes lower bounds and near-optimal layers: it splits a layer's problem into strips
// whose droplets must agree on windows at the cuts.
//
// The rows whose cost counts are cut into strips of m. A strip's costs depend on its own droplets and on
// those of one row above and below, so the droplets of the two rows at each cut belong to two strips, each of
// which has its own copy. For every window of these two rows and three columns a function of its 64 patterns
// (the multipliers) is added to the upper strip and taken from the lower. A layer's copies agree, so that no
// choice of multipliers changes its cost. So the sum of the strips' minima, exact by dynamic programming
// (window_kernel.h), is a lower bound for every layer. Multipliers are found by passing on min-marginals, not
// by subgradients: in a downward sweep a strip passes its min-marginals of the lower cut's windows, one after
// the other, to the strip below, and in an upward sweep to the one above [as sequential reweighted message
// passing does on graphs: Kolmogorov 2006; Tourani et al. 2018, "MPLP++"]. The strip's own minimum does not
// change by that. The minimum of its neighbour cannot fall. So the bound never falls, and mostly converges
// within ten sweeps. Deciding the strips one after the other then gives a layer near the optimum.
#pragma once

#include <vector>

#include "core/control/mpc/layer/layer_problem.h"
#include "core/control/mpc/layer/window_kernel.h"
#include "core/grid/parallel.h"

namespace firn::control::mpc {

enum class SweepDirection { kDown, kUp };

class DualDecomposition {
 public:
  /// 256 / m bytes per cell. @param rows m, 1..4. @throws std::invalid_argument: another number
  /// @param problem its droplets do not matter
  DualDecomposition(const LayerProblem& problem, int rows, const CellCost& cost = {});

  /// The multipliers stay: they prove something of any cost, and much of one that is alike.
  void set_cost(const CellCost& cost) { cost_ = cost; }

  /// Visits every strip once, passing everything on downwards or upwards. Groups of strips run at the same
  /// time, the same groups for any number of threads. @returns the sum of the strips' minima, the bound up to
  /// rounding
  double sweep(SweepDirection direction, const ParallelFor& parallel);

  /// Decides strip after strip, each optimal for the multipliers of those to come. To be called after a sweep
  /// in the other direction. Sets the droplets of `layer`, a problem like the one split.
  void decide(SweepDirection direction, LayerProblem& layer) const;

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
  double visit(int s, SweepDirection direction, Work& work);

  LayerProblem bare_;
  int rows_, nx_, ny_, strips_;
  CellCost cost_;
  std::vector<float> shared_;
};

}  // namespace firn::control::mpc
