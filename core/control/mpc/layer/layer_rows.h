// LayerRowKernels computes the errors after a layer for whole rows,
// eight cells in registers. Element by element, no fused operations: the same bytes from every processor, and
// those of the plain loops in the tests.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace firn::control::mpc {

/// Rows are read in blocks of kRowBlock cells: the padding after the last cell of a row, up to a whole block,
/// is readable, does not count and holds no droplet.
inline constexpr std::size_t kRowBlock = 8;
constexpr std::size_t whole_blocks(std::size_t cells) {
  return (cells + kRowBlock - 1) / kRowBlock * kRowBlock;
}

/// A droplet of one ink [Lu 2015, Eqs. (3)-(5)]: 0 sides, 1 corners.
struct RowInk {
  float drop_mm, w_mm[2], slope[2];
  float beyond_mm[2];  ///< flow to cells beyond the border: w (lost) or 0
};

/// One row of cells; `stride` leads to its neighbours in the rows above and below, which lie in the same
/// memory.
struct RowCells {
  const float* height_mm;
  const float* bare_mm;                ///< error without droplets
  const float* error_mm;               ///< 0 on cells that do not count
  const std::uint8_t *counts, *drops;  ///< 0 or 1
  std::ptrdiff_t stride;
};

struct LayerRowKernels {
  const char* name;
  /// The errors that the droplets leave, of rows from the first of the grid on: bare + the heights from the
  /// droplets of the nine cells, summed in the raster order of the droplets.
  void (*errors)(const RowCells& first, const RowInk& ink, std::size_t nx, std::size_t rows, float* error_mm);
};

/// Those that this processor can run, the most portable first, the fastest last.
std::span<const LayerRowKernels> layer_row_kernels();

}  // namespace firn::control::mpc
