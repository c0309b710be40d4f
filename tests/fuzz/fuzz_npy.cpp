// Any bytes as an NPY file.
#include <stdexcept>

#include "core/grid/npy.h"
#include "tests/fuzz/require.h"

using namespace firn;
using namespace firn::fuzz;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto bytes = as_bytes(data, size);
  GridSpec grid;
  try {
    const NpyShape shape = npy_shape(bytes, "fuzz.npy");
    // Larger grids only cost time; that the shape must fit the bytes is checked before anything is allocated
    // for it.
    if (std::int64_t(shape.nx) * shape.ny > 100000) return 0;
    grid.nx = shape.nx;
    grid.ny = shape.ny;
    grid.pitch_x_mm = grid.pitch_y_mm = 1;
  } catch (const std::invalid_argument&) {
    return 0;
  }
  try {
    require(
        height_map_from_npy(bytes, grid, "fuzz.npy").size() == std::size_t(grid.nx) * std::size_t(grid.ny),
        "the map has the grid's cells");
  } catch (const std::invalid_argument&) {
  }
  try {
    for (const std::uint8_t cell : mask_from_npy(bytes, grid, "fuzz.npy").cells)
      require(cell <= 1, "a mask is 0 or 1");
  } catch (const std::invalid_argument&) {
  }
  return 0;
}
