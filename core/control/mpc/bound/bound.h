// lower_bound() computes a lower bound of the sum of |error| over all layers of at most one droplet per cell.
// The multipliers come from the dual decomposition (dual_decomposition.h), in single precision. The value
// that they prove is then computed by the reader's checker (bound_checker.h), in double precision from the
// heights themselves.
#pragma once

#include <vector>

#include "core/control/controller.h"
#include "core/control/mpc/layer/dual_decomposition.h"
#include "core/grid/parallel.h"

namespace firn::control::mpc {

struct BoundOptions {
  int rows = 2;         ///< m, 1..4: higher strips prove more, and cost three times as much per row more
  int sweeps = 40;      ///< at most, of the decomposition
  double gap = 0.0;     ///< ends when (known - bound) / known is no larger,
  double stall = 1e-7;  ///< or when ten sweeps raise the bound by less than this part of it
  CellCost cost = {};   ///< of which the sum is bounded
};

struct LowerBound {
  double total_mm = 0.0;  ///< of the sum of |error|, as proved by the multipliers
  int sweeps = 0;
  int rows = 0;                    ///< m
  std::vector<float> multipliers;  ///< the certificate: DualDecomposition::multipliers()
  std::vector<double> history_mm;  ///< bound after each sweep, up to rounding in single precision
};

/// Sweeps `split` until one of the options ends it. @returns the bound after each sweep, up to rounding in
/// single precision
std::vector<double> raise_bound(DualDecomposition& split, double known_mm, const BoundOptions& options,
                                const ParallelFor& parallel,
                                const std::function<void(double bound_mm)>& watch = {});

/// @param known_mm sum of |error| of a known layer: ends at options.gap from it; 0: none
/// @param watch called after each sweep with the bound so far; may be empty
/// @throws std::invalid_argument: rows outside 1..4.
LowerBound lower_bound(const Setup& setup, const HeightMap& height, const MaterialMap& materials,
                       double known_mm, const BoundOptions& options, const ParallelFor& parallel,
                       const std::function<void(double bound_mm)>& watch = {});

}  // namespace firn::control::mpc
