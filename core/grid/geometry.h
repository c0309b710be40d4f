// Geometry holds the part inside a printed block of two inks: the set M of [Lu 2015, IV-B], as columns over
// the grid's cells.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/grid/material.h"

namespace firn {

/// A body in space with a point-in-body test: an analytic shape, a stack of images, a mesh.
class Solid {
 public:
  virtual ~Solid() = default;
  virtual bool contains(double x_mm, double y_mm, double z_mm) const = 0;  ///< z from the substrate up
};

/// Heights [from_mm, to_mm) of a column that lie inside M.
struct Span {
  double from_mm = 0.0;
  double to_mm = 0.0;
  bool operator==(const Span&) const = default;
};

/// M, cell by cell: the intervals in which a column through the cell's centre lies inside M. The rest of the
/// block is support.
class Geometry {
 public:
  /// @param spans per cell, ascending and apart. @param height_mm top of the block C (h_d's largest value).
  /// @throws std::invalid_argument naming the cell: spans not finite, empty, out of order or outside [0,
  /// height_mm]; another number of cells than the grid's.
  Geometry(const GridSpec& grid, double height_mm, const std::vector<std::vector<Span>>& spans);

  /// Columns of a solid: each is sampled every `step_mm` (from step / 2 on) and each change is bisected down
  /// to step / 2^20; features thinner than a step may be missed. @throws std::invalid_argument: height or
  /// step not above 0, more than a million steps.
  static Geometry sampled(const Solid& solid, const GridSpec& grid, double height_mm, double step_mm);

  /// I_A and I_B [Lu 2015, IV-B]: kA where (cell centre, z) lies in M, else kB. A height below the substrate
  /// counts as the substrate, one at or above the block's top as just below it (the paper cuts M off there,
  /// so that a droplet on a finished top would be support).
  Material at(std::size_t cell, double z_mm) const;
  std::span<const Span> spans(std::size_t cell) const {
    return {spans_.data() + first_[cell], first_[cell + 1] - first_[cell]};
  }
  const GridSpec& grid() const { return grid_; }
  double height_mm() const { return height_mm_; }
  bool operator==(const Geometry&) const = default;

 private:
  GridSpec grid_;
  double height_mm_;
  std::vector<std::uint32_t> first_;  // of each cell's spans; one more at the end
  std::vector<Span> spans_;
};

/// Bytes of a geometry as the nodes read them: magic "FIRNGEO1", nx, ny (i32), height (f64), per cell a count
/// (u32), then all spans (two f64 each); little-endian.
std::vector<std::byte> to_bytes(const Geometry& geometry);
/// @throws std::invalid_argument with `name`, the byte offset and the fault: magic, length, another grid than
/// `grid`, spans as in the constructor.
Geometry geometry_from_bytes(std::span<const std::byte> bytes, const GridSpec& grid, const std::string& name);

}  // namespace firn
