// MaterialMap holds the ink of each cell of a grid: the object's (A) and the support's (B), which is washed
// away after the print.
#pragma once

#include <cstdint>

#include "core/grid/grid.h"

namespace firn {

/// Ink of a droplet, of a cell or of a point. A = object, B = support (sacrificial) [Lu 2015, III-D].
enum class Material : std::uint8_t { kNone = 0, kA = 1, kB = 2 };

/// The ink of each cell's droplets in one layer: I_A and I_B of [Lu 2015, IV-B]. kNone: no droplets there.
struct MaterialMap : Grid<std::uint8_t> {
  using Grid::Grid;
  Material of(std::size_t cell) const { return Material(cells[cell]); }
  void set(std::size_t cell, Material m) { cells[cell] = std::uint8_t(m); }
};

}  // namespace firn
