// OffsetChange computes the height change of a layer whose droplets land beside the centres of their cells:
// one kernel of 5 x 5 cells for each place, flows by the rule of [Lu 2015, Eqs. (4), (5)] for each pair of
// cells.
//
// A droplet on cell c at place o raises a cell n by w sat_{k + w}(H_c - H_n), w the height that its kernel
// has at n and k that at c, and c by k plus what the others do not take. So it adds the sum of its kernel,
// whatever the ground, and for the centre's kernel h1, h2, h3 the rule is (4). Lu's model has no meaning
// between cells: kernels of the other places are measured (firn identify), or mixed from the centre's as a
// start.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/deposition/height_change.h"
#include "core/grid/material.h"
#include "core/grid/offsets.h"

namespace firn::deposition {

/// Height that one droplet adds on flat ground to the cell (dx, dy) from its own, -2 <= dx, dy <= 2 [mm].
struct OffsetKernel {
  static constexpr int kRadius = 2, kSide = 2 * kRadius + 1, kCells = kSide * kSide;
  std::array<double, kCells> height_mm{};  ///< row by row from the lowest y

  static constexpr std::size_t index(int dx, int dy) {
    return std::size_t((dy + kRadius) * kSide + dx + kRadius);
  }
  double at(int dx, int dy) const { return height_mm[index(dx, dy)]; }
  double drop_height_mm() const;  ///< height that it adds over all cells
  bool operator==(const OffsetKernel&) const = default;
};

/// The centre's kernel: h1, h2, h3.
OffsetKernel kernel_of(const DropletModel& model);
/// The kernels of the four cells around a place, mixed bilinearly: keeps the volume, and is off by up to 0.07
/// of a droplet, since footprints are no tents. A start where nothing was measured.
OffsetKernel mixed_kernel(const DropletModel& model, Offset place);

/// Range of a measured height.
inline constexpr Range kPlaceHeight_mm = within(0, 10);
/// Range of OffsetModel::range_mm.
inline constexpr Range kFlowRange_mm = within(0, 10);

/// The kernel of each place of a table, by its index.
struct OffsetModel {
  OffsetTable table;
  std::vector<OffsetKernel> kernels = {kernel_of(DropletModel{})};
  /// Ground this much above a droplet's own cell takes none of it; 0, or less than k + w: k + w, the range of
  /// (5). Ink that lands across a step needs a higher one to be turned back.
  double range_mm = 0.0;

  double range_of(int place, double w_mm) const {
    return std::max(range_mm, kernels[std::size_t(place)].at(0, 0) + w_mm);
  }

  bool operator==(const OffsetModel&) const = default;
};
/// @param range_mm OffsetModel::range_mm
/// @param heights_mm 25 for each place but the centre, in the order of OffsetKernel; empty: mixed, and those
/// of small droplets their share of it
/// @throws std::invalid_argument: another number of heights; one outside kPlaceHeight_mm; a flow range
/// outside kFlowRange_mm; a kernel that adds nothing to its own cell
OffsetModel offset_model(const DropletModel& model, const OffsetTable& table,
                         std::span<const double> heights_mm = {}, double range_mm = 0.0);

/// The rule on one grid.
class OffsetChange {
 public:
  /// @param model of ink A, or of the only one; @param model_b of ink B, on the same table
  /// @throws std::invalid_argument: grid out of range; a model without a kernel for each place
  OffsetChange(const GridSpec& grid, OffsetModel model, Border border, OffsetModel model_b = {});

  /// Adds `drops` to `height`: pass by pass as HeightChange::deposit, every droplet of a cell at the cell's
  /// place.
  /// @param offsets without cells: all in the centres; @param inks without cells: all ink A
  /// @throws std::invalid_argument before anything is changed: sizes differ from the grid, a height is not
  /// finite, an index beyond the table
  Ledger deposit(HeightMap& height, const DropletPattern& drops, const OffsetMap& offsets,
                 const MaterialMap& inks = {});

 private:
  GridSpec grid_;
  OffsetModel model_, model_b_;
  Border border_;
  std::vector<double> change_;
};

}  // namespace firn::deposition
