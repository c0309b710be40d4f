// decide_one_layer() computes a layer of at most one droplet per cell and one ink, alpha = 1, with little
// memory, so that grids of 4096 x 4096 cells fit (LayerProblem's 14 bytes per cell; HorizonObjective takes
// 160).
#pragma once

#include <string>

#include "core/control/controller.h"
#include "core/control/mpc/layer/layer_solver.h"
#include "core/grid/parallel.h"

namespace firn::control::mpc {

/// Above that many cells strips alone decide, from the full layer: the split takes 128 bytes per cell, error
/// diffusion 16.
inline constexpr std::size_t kMaxSplitCells = 1'000'000;

/// avg|h_d - H| over the mask after one layer [Lu 2015, Eqs. (4), (8)], by the height-change model in double
/// precision, a few rows at a time: the same bytes as the model on the whole grid.
double mean_error_mm(const Setup& setup, const HeightMap& height, const DropletPattern& drops);

/// Height that a layer adds to all cells beside the mask, and over a border that loses, by the same model.
double outside_rise_mm(const Setup& setup, const HeightMap& height, const DropletPattern& drops);

struct OneLayer {
  DropletPattern drops;
  double objective_mm =
      0.0;  ///< mean |error|, and options.outside_price times the height beside the part by cells
  std::int64_t strips = 0;  ///< solved
  bool settled = false;     ///< no strip of the widest kind improves it
  LayerSolution certified;  ///< of kCertified
};

/// Sweeps and gap of kCertified.
LayerSolverOptions certified_options(const MpcOptions& options);

/// Returns "; after 12 sweeps, no layer is better by more than 0.050000 %", or "" for the one sweep that is
/// the default.
std::string reached(const MpcOptions& options, const LayerSolution& solution);

/// Improves `guess` by strips of 2 up to options.strip_rows rows (kStripDp) or by dual decomposition
/// (kCertified). Above kMaxSplitCells both do the same.
/// @param height finite everywhere
OneLayer decide_one_layer(const Setup& setup, const HeightMap& height, const DropletPattern& guess,
                          const MpcOptions& options, const ParallelFor& parallel);

}  // namespace firn::control::mpc
