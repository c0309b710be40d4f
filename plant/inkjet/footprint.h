// footprint() returns the function that computes a droplet's landing on the fine cells under it. All
// instruction sets give the same bytes: no fused operations, no reordered sums.
#pragma once

#include "plant/config/world_config.h"

namespace firn::plant {

constexpr int kMaxFootprint = 32;  ///< fine cells along a footprint's side

/// Holds the part of a field under a footprint, nx x ny fine cells. @pre nx, ny in 1 .. kMaxFootprint
struct FieldWindow {
  double* solid;   ///< heights [mm]; cell (a, b) at b * stride + a
  double* liquid;  ///< likewise
  int stride, nx, ny;
};

/// Adds `depth_cells` = volume / area of a fine cell [mm] of liquid about the centre (u, v), in fine cells of
/// dx_mm x dy_mm from the window's corner, then levels it (Field::land).
using Footprint = void (*)(const FieldWindow&, const DropletParams&, double depth_cells, double u, double v,
                           double dx_mm, double dy_mm);

/// Returns the widest that this processor has.
Footprint footprint();
/// Returns the one without machine-specific instructions, against which tests compare.
Footprint portable_footprint();

}  // namespace firn::plant
