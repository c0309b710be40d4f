#include "replay/ice_error.h"

#include <cmath>

#include "core/slice/coverage/footprint.h"

namespace firn::replay {
namespace {

double nominal_mm(const slice::LayerPaths& l) { return l.z * slice::kMmPerUnit; }

}  // namespace

HeightMap cell_means(const HeightMap& field, const GridSpec& grid) {
  HeightMap sum(grid, 0.0);
  Grid<double> count(grid);
  for (int j = 0; j < field.spec.ny; ++j)
    for (int i = 0; i < field.spec.nx; ++i) {
      const int a = int(std::floor((field.spec.x_mm(i) - grid.origin_x_mm) / grid.pitch_x_mm + 0.5));
      const int b = int(std::floor((field.spec.y_mm(j) - grid.origin_y_mm) / grid.pitch_y_mm + 0.5));
      if (a < 0 || b < 0 || a >= grid.nx || b >= grid.ny) continue;
      sum.at(a, b) += field.at(i, j);
      count.at(a, b) += 1.0;
    }
  for (std::size_t c = 0; c < sum.size(); ++c)
    sum.cells[c] = count.cells[c] > 0.0 ? sum.cells[c] / count.cells[c] : kNotMeasured;
  return sum;
}

Mask judged_cells(const slice::LayerPaths& layer, const GridSpec& g) {
  const Mask footprint = slice::without_narrow_holes(
      slice::footprint_mask(slice::footprint_materials(layer, g)), kWidestSpot_mm);
  Mask inner(g);
  for (int j = 1; j + 1 < g.ny; ++j)
    for (int i = 1; i + 1 < g.nx; ++i) {
      bool in = true;
      for (int dj = -1; dj <= 1; ++dj)
        for (int di = -1; di <= 1; ++di) in = in && footprint.at(i + di, j + dj) != 0;
      inner.at(i, j) = in;
    }
  return inner;
}

ErrorStats ice_error(const HeightMap& field, const slice::LayerPaths& layer, double pitch_mm) {
  const GridSpec grid = slice::footprint_grid(layer, pitch_mm);
  return error_stats(cell_means(field, grid), HeightMap(grid, nominal_mm(layer)), judged_cells(layer, grid));
}

}  // namespace firn::replay
