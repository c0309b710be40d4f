#include "core/control/mpc/edge_reference.h"

#include <algorithm>

namespace firn::control {

EdgeReference::EdgeReference(const Setup& s, double lag_layers, double rise_layers)
    : mask_(s.mask),
      lag_(s.grid),
      layer_mm_(s.model.layer_height_mm()),
      rise_mm_(rise_layers * s.model.layer_height_mm()) {
  const auto outside = [&s](int i, int j) { return !s.grid.contains(i, j) || !s.mask.at(i, j); };
  Grid<std::uint8_t> row(
      s.grid);  // from the outline: 1 with a side outside, 2 and 3 beside the row before, else 0
  for (int j = 0; j < s.grid.ny; ++j)
    for (int i = 0; i < s.grid.nx; ++i) {
      if (!s.mask.at(i, j)) continue;
      const int sides =
          int(outside(i - 1, j)) + int(outside(i + 1, j)) + int(outside(i, j - 1)) + int(outside(i, j + 1));
      row.at(i, j) = sides > 0;
      lag_.at(i, j) = double(sides) * lag_layers * layer_mm_;
    }
  for (const std::uint8_t n : {std::uint8_t{2}, std::uint8_t{3}})
    for (int j = 0; j < s.grid.ny; ++j)
      for (int i = 0; i < s.grid.nx; ++i) {
        if (!s.mask.at(i, j) || row.at(i, j) != 0) continue;
        for (int dy = -1; dy <= 1; ++dy)
          for (int dx = -1; dx <= 1; ++dx)
            if (s.grid.contains(i + dx, j + dy) && row.at(i + dx, j + dy) == n - 1) row.at(i, j) = n;
        if (row.at(i, j) == 3) lag_.at(i, j) = lag_layers * layer_mm_;
      }
}

std::optional<HeightMap> EdgeReference::next(const HeightMap& target, const HeightMap& height) const {
  double cells = 0.0, sum_mm = 0.0;
  for (std::size_t c = 0; c < height.size(); ++c) {
    if (!mask_.cells[c] || target.cells[c] - lag_.cells[c] - height.cells[c] <= 0.5 * layer_mm_) continue;
    cells += 1.0;
    sum_mm += height.cells[c] + lag_.cells[c];
  }
  if (cells == 0.0) return std::nullopt;
  const double level_mm = sum_mm / cells + rise_mm_;
  HeightMap next(target.spec);
  for (std::size_t c = 0; c < next.size(); ++c)
    if (mask_.cells[c]) next.cells[c] = std::max(0.0, std::min(target.cells[c], level_mm) - lag_.cells[c]);
  return next;
}

}  // namespace firn::control
