// InkStack holds the columns of inks on the fine field, computed from each ink's rise of the cells' mean
// heights between two cures.
#pragma once

#include <array>
#include <vector>

#include "core/grid/material_columns.h"
#include "plant/record/archive.h"

namespace firn::plant {

/// Adds one segment per ink and cure to every cell's column: the rise of the cell's mean height since the
/// last cure, shared in proportion to each ink's rise while it was fired, A under B. Ink that a neighbour's
/// droplet spilt over counts in the cell where it came to rest. The rise includes levelling and shrinking, so
/// a column's top is its cell's mean height.
class InkStack {
 public:
  explicit InkStack(const GridSpec& grid)
      : columns_(grid), cured_mm_(grid.size(), 0.0), seen_mm_(grid.size(), 0.0) {
    for (auto& share : brought_mm_) share.assign(grid.size(), 0.0);
  }

  /// Reads the cells' present means; the rise since the last call is attributed to `ink`.
  void account(const HeightMap& means, Material ink) {
    std::vector<double>& brought = brought_mm_[ink == Material::kB];
    for (std::size_t c = 0; c < seen_mm_.size(); ++c) {
      brought[c] += means.cells[c] - seen_mm_[c];
      seen_mm_[c] = means.cells[c];
    }
  }
  /// Adds the segments of a cure.
  void cured(const HeightMap& means) {
    for (std::size_t c = 0; c < cured_mm_.size(); ++c) {
      const double gain = means.cells[c] - cured_mm_[c];
      double a = brought_mm_[0][c] > 0.0 ? brought_mm_[0][c] : 0.0;
      double b = brought_mm_[1][c] > 0.0 ? brought_mm_[1][c] : 0.0;
      if (gain > 0.0 && a + b > 0.0) {
        columns_.add(c, gain * a / (a + b), Material::kA);
        columns_.add(c, gain * b / (a + b), Material::kB);
      }
      brought_mm_[0][c] = brought_mm_[1][c] = 0.0;
      cured_mm_[c] = seen_mm_[c] = means.cells[c];
    }
  }
  const MaterialColumns& columns() const { return columns_; }
  void io(Archive& a) { a.all(columns_, cured_mm_, seen_mm_, brought_mm_[0], brought_mm_[1]); }

 private:
  MaterialColumns columns_;
  std::vector<double> cured_mm_;                   ///< means at the last cure
  std::vector<double> seen_mm_;                    ///< means at the last account
  std::array<std::vector<double>, 2> brought_mm_;  ///< by ink, since the last cure
};

}  // namespace firn::plant
