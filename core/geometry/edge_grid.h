// Edges by the cells of a raster that they pass, so that neighbours are found in expected linear time.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/exact.h"

namespace firn::slice {

class EdgeGrid {
 public:
  /// About four cells per edge. Every edge is listed in each cell that it passes within `margin` units.
  void build(std::span<const Edge> edges, std::int32_t margin);

  std::size_t cells() const { return first_.empty() ? 0 : first_.size() - 1; }
  std::span<const std::uint32_t> cell(std::size_t n) const {
    return {edges_.data() + first_[n], first_[n + 1] - first_[n]};
  }
  /// The cell of a point within the box of the edges.
  std::size_t cell_of(const Point& p) const {
    return std::size_t((std::int64_t(p.y) - low_y_) >> shift_) * across_ +
           std::size_t((std::int64_t(p.x) - low_x_) >> shift_);
  }

 private:
  template <class Visit>
  void pass(const Edge& e, std::int32_t margin, const Visit& visit) const;

  std::int64_t low_x_ = 0, low_y_ = 0;
  std::size_t across_ = 1, along_ = 1;
  int shift_ = 0;
  std::vector<std::uint32_t> first_, edges_;
};

}  // namespace firn::slice
