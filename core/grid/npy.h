// Reads and writes grids as NumPy .npy bytes: the form in which targets and masks reach the nodes, and in
// which users supply states. Format: https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html
// (versions 1.0, 2.0).
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "core/grid/grid.h"

namespace firn {

/// Row-major (ny, nx) array. dtype '<f8', '<f4' (heights) or '|u1', '|b1' (patterns, masks).
/// @throws std::invalid_argument with `name`, the byte offset and the fault: magic, version, dtype, Fortran
/// order, shape not 2-D, side above kMaxGridSide, length not equal to the shape's.
HeightMap height_map_from_npy(std::span<const std::byte> bytes, const GridSpec& geometry,
                              const std::string& name);
Mask mask_from_npy(std::span<const std::byte> bytes, const GridSpec& geometry, const std::string& name);

/// Shape only: {ny, nx}.
struct NpyShape {
  int ny = 0;
  int nx = 0;
};
NpyShape npy_shape(std::span<const std::byte> bytes, const std::string& name);

std::vector<std::byte> to_npy(const HeightMap& map);           ///< '<f8'
std::vector<std::byte> to_npy(const Grid<std::uint8_t>& map);  ///< '|u1'

}  // namespace firn
