// Grid holds values on a rectangular grid of cells: heights, droplet counts, masks. GridSpec holds the places
// of the cells. Depends on core/options alone.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/options/option.h"

namespace firn {

/// Number of finished layers; layer k is the k-th deposited one, the bare substrate is layer 0.
enum class LayerIndex : std::int32_t {};

/// A rectangular grid of droplet cells. Cell (i, j) has its centre at
/// (origin_x_mm + i * pitch_x_mm, origin_y_mm + j * pitch_y_mm), 0 <= i < nx, 0 <= j < ny.
/// Storage is row-major with rows along x: index = j * nx + i (a NumPy array of shape (ny, nx)).
struct GridSpec {
  std::int32_t nx = 0;
  std::int32_t ny = 0;
  double pitch_x_mm = 1.0;
  double pitch_y_mm = 1.0;
  double origin_x_mm = 0.0;
  double origin_y_mm = 0.0;

  std::size_t size() const { return std::size_t(nx) * std::size_t(ny); }
  std::size_t index(int i, int j) const { return std::size_t(j) * std::size_t(nx) + std::size_t(i); }
  bool contains(int i, int j) const { return i >= 0 && j >= 0 && i < nx && j < ny; }
  double x_mm(int i) const { return origin_x_mm + i * pitch_x_mm; }
  double y_mm(int j) const { return origin_y_mm + j * pitch_y_mm; }
  bool operator==(const GridSpec&) const = default;
};

/// Largest grid side that any message, file or configuration may name.
inline constexpr int kMaxGridSide = 4096;

inline constexpr OptionTable kGridSpec{
    Option{"nx", &GridSpec::nx, "", within(1, kMaxGridSide), "cells along x"},
    Option{"ny", &GridSpec::ny, "", within(1, kMaxGridSide), "cells along y"},
    Option{"pitch_x_mm", &GridSpec::pitch_x_mm, "mm", above(0, 100),
           "distance of cells along x [Lu 2015, Table I]"},
    Option{"pitch_y_mm", &GridSpec::pitch_y_mm, "mm", above(0, 100), "distance of cells along y"},
    Option{"origin_x_mm", &GridSpec::origin_x_mm, "mm", within(-1e4, 1e4),
           "stage position of the centre of cell (0, 0)"},
    Option{"origin_y_mm", &GridSpec::origin_y_mm, "mm", within(-1e4, 1e4), "the same along y"},
};

/// @throws std::invalid_argument naming the field that is out of its range.
void check(const GridSpec& spec);

/// Values on a grid, one per cell.
template <class T>
struct Grid {
  GridSpec spec;
  std::vector<T> cells;

  Grid() = default;
  explicit Grid(const GridSpec& s, T value = T{}) : spec(s), cells(s.size(), value) {}
  T& at(int i, int j) { return cells[spec.index(i, j)]; }
  const T& at(int i, int j) const { return cells[spec.index(i, j)]; }
  std::size_t size() const { return cells.size(); }
  T* data() { return cells.data(); }
  const T* data() const { return cells.data(); }
  bool operator==(const Grid&) const = default;
};

inline constexpr double kNotMeasured = std::numeric_limits<double>::quiet_NaN();

/// Heights above the substrate [mm]; NaN = not measured.
struct HeightMap : Grid<double> {
  using Grid::Grid;
};

/// Droplets to deposit per cell, 0..255; a cell with n drops gets them in n passes.
struct DropletPattern : Grid<std::uint8_t> {
  using Grid::Grid;
  std::int64_t total() const;
  int passes() const;  ///< the largest count of any cell
};

/// 1 where a cell belongs to the part, else 0.
struct Mask : Grid<std::uint8_t> {
  using Grid::Grid;
  std::int64_t count() const;
};

/// Error statistics of `height - target` over the cells with mask 1 and a finite height. Sums run in
/// index order, so equal input gives equal bytes.
struct ErrorStats {
  std::int64_t cells = 0;    ///< cells that counted
  std::int64_t missing = 0;  ///< masked cells with no measured height
  double mean_mm = 0.0;      ///< signed mean of height - target
  double mean_abs_mm = 0.0;
  double rms_mm = 0.0;  ///< about the target
  double std_mm = 0.0;  ///< about the mean
  double min_mm = 0.0;
  double max_mm = 0.0;
};
ErrorStats error_stats(const HeightMap& height, const HeightMap& target, const Mask& mask);

/// Bilinear resampling of `from` onto `to`; cells outside the old footprint get `outside`
/// (a new cell of an integral or derivative surface starts at zero [Barnett, 5.1.2]); a NaN corner with
/// non-zero weight gives NaN.
HeightMap resample(const HeightMap& from, const GridSpec& to, double outside);

}  // namespace firn
