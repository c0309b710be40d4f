// tiled_greedy() computes a layer of at most one droplet per cell for grids on which the sums of a
// HorizonObjective, 250 bytes a cell, do not fit: by the greedy search [Lu 2015, IV-C] of one tile of the
// grid after the other, with the memory of one tile on each thread.
#pragma once

#include <cstdint>

#include "core/control/controller.h"
#include "core/grid/parallel.h"

namespace firn::control::mpc {

/// Cells of the part above which Mpc decides so.
inline constexpr std::size_t kTiledCells = std::size_t(1) << 18;

struct TiledLayer {
  DropletPattern drops;
  double objective_mm = 0.0;  ///< mean |error|, and outside_price times the height beside the part by cells
  std::int64_t evaluations = 0;  ///< of single-droplet changes
  bool optimal = false;          ///< no single-droplet change anywhere lowers the objective
};

/// Searches one layer at alpha = 1 by |error|. A change of one droplet then alters the errors of its nine
/// cells alone, so a tile with the heights and droplets of two cells around it knows all that its own
/// droplets do. The first guess is the dithered one of each tile (of options.start_dithered, else the full
/// layer). Tiles that share no cell of these surroundings are searched at the same time, and tiles beside
/// which a droplet changed are searched again, until none changes or the evaluations are used up. Draws are
/// keyed by tile and pass: the same bytes for any number of threads.
/// @param setup one ink, no rim, no places @param height finite everywhere
TiledLayer tiled_greedy(const Setup& setup, const HeightMap& height, const MpcOptions& options, int layer,
                        int attempt, const ParallelFor& parallel);

}  // namespace firn::control::mpc
