// LayerProblem holds one layer of at most one droplet per cell, alpha = 1, as an optimisation problem: choose
// u in {0, 1} per printable cell to minimise the sum of |e| over the cells that count, where e = height -
// target + A(height) u is linear in u for given heights [Lu 2015, Eqs. (4), (8) with N = 1]. Single precision
// and 14 bytes per cell, so that grids up to 4096 x 4096 fit; the caller evaluates results in double
// precision.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/control/controller.h"
#include "core/control/mpc/layer/layer_rows.h"

namespace firn::control::mpc {

class LayerProblem {
 public:
  /// @param materials ink of each cell; empty: ink A everywhere
  /// @pre heights finite everywhere
  LayerProblem(const Setup& setup, const HeightMap& height, const MaterialMap& materials);

  int nx() const { return nx_; }
  int ny() const { return ny_; }
  std::int64_t counted() const { return counted_; }  ///< cells that count in the objective
  bool printable(int i, int j) const { return counts_[at(i, j)] != 0; }
  std::uint8_t drop(int i, int j) const { return drops_[at(i, j)]; }
  /// height - target with the present droplets; 0 on cells that do not count
  float error_mm(int i, int j) const { return error_[at(i, j)]; }
  const float* error_row(int j) const { return error_.data() + at(0, j); }  ///< nx values; j from -1 to ny

  /// Height that a droplet on cell (i, j) adds to the cell at (i + dx, j + dy): index (dy + 1) * 3 + dx + 1;
  /// 0 on cells that do not count.
  using Effect = std::array<float, 9>;
  Effect effect(int i, int j) const;
  void effects(int j, float* out) const;  ///< of row j: out[q * nx + i] = effect(i, j)[q]
  /// Height that a droplet on a printable cell adds to all cells that do not count, over a border that loses
  /// too.
  float outside_mm(int i, int j) const;

  void set_drop(int i, int j, std::uint8_t drop);  ///< keeps the errors up to date
  void set_drops(const DropletPattern& drops);     ///< cells that are not printable stay empty
  DropletPattern drops(const GridSpec& grid) const;
  void clear();  ///< no droplets

  /// Sum of |error| over the counted cells, from the present errors, in a fixed order [mm].
  double total_mm() const;
  /// Errors anew from heights, targets and droplets, the forward model of the layer: single-droplet updates
  /// drift by rounding.
  void refresh();

 private:
  std::size_t at(int i, int j) const { return std::size_t(j + 1) * row_ + std::size_t(i + 1); }

  struct Ink {
    float drop_mm = 0.0f;
    std::array<float, 9> w_mm{}, slope{};
  };
  RowCells row_at(int j) const;
  RowInk row_ink() const;  // of ink A
  int nx_, ny_;
  std::size_t row_;  // padded: a cell at each end, the row in whole blocks
  std::int64_t counted_ = 0;
  std::array<Ink, 2> inks_;
  std::vector<float> height_;        // padded: beyond the border infinitely low (lose) or high (keep)
  std::vector<float> bare_, error_;  // padded: without droplets, with them
  std::vector<std::uint8_t> counts_, drops_, inks_of_;  // padded; inks_of_ empty with one ink
};

}  // namespace firn::control::mpc
