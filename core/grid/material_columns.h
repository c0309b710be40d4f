// MaterialColumns holds the materials of a printed block: per cell a column of segments of one ink each, from
// the substrate up.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/grid/material.h"

namespace firn {

/// Ink up to `top_mm`, from the top of the segment below (the first one from 0).
struct MaterialSegment {
  double top_mm = 0.0;
  Material material = Material::kNone;
};

/// The plant's record of the inks in the block. No node reads it.
class MaterialColumns {
 public:
  MaterialColumns() = default;  ///< of nothing: no cells
  explicit MaterialColumns(const GridSpec& grid) : grid_(grid), columns_(grid.size()) {}

  /// `thickness_mm` of ink on top of a cell. One ink on itself is one segment; 0 or less is ignored.
  /// @pre material is kA or kB
  void add(std::size_t cell, double thickness_mm, Material material);

  /// The ink at a height; kNone at and above the top. @pre z_mm >= 0
  Material at(std::size_t cell, double z_mm) const;
  /// The ink with the largest share of [from_mm, to_mm), air (kNone) among them; the first of A, B, none in a
  /// tie.
  Material most(std::size_t cell, double from_mm, double to_mm) const;
  double top_mm(std::size_t cell) const {
    return columns_[cell].empty() ? 0.0 : columns_[cell].back().top_mm;
  }
  std::span<const MaterialSegment> column(std::size_t cell) const { return columns_[cell]; }
  bool empty() const { return columns_.empty(); }
  const GridSpec& grid() const { return grid_; }

  /// For saving: visit(grid), visit(columns).
  template <class Archive>
  void io(Archive& a) {
    a.all(grid_, columns_);
  }

 private:
  GridSpec grid_;
  std::vector<std::vector<MaterialSegment>> columns_;
};

}  // namespace firn
