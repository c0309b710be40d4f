#include "replay/ice_error.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "core/slice/coverage/footprint.h"

namespace firn::replay {
namespace {

double nominal_mm(const slice::LayerPaths& l) { return l.z * geometry::kMmPerUnit; }

bool deposits(const slice::LayerPaths& layer) {
  return std::ranges::any_of(layer.info,
                             [](const slice::PathInfo& i) { return i.kind != PathKind::kMeasurement; });
}

// The smallest grid that holds both, of grids whose cells coincide.
GridSpec united(const GridSpec& a, const GridSpec& b) {
  const double pitch = a.pitch_x_mm;
  const double x = std::min(a.origin_x_mm, b.origin_x_mm), y = std::min(a.origin_y_mm, b.origin_y_mm);
  const double x_end = std::max(a.x_mm(a.nx), b.x_mm(b.nx)), y_end = std::max(a.y_mm(a.ny), b.y_mm(b.ny));
  return {int(std::lround((x_end - x) / pitch)), int(std::lround((y_end - y) / pitch)), pitch, pitch, x, y};
}

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

NominalPart nominal_part(const slice::PrintPaths& paths, double pitch_mm, double margin_mm, NominalOf of) {
  std::optional<GridSpec> grid;
  for (const slice::LayerPaths& l : paths.layers)
    if (deposits(l)) {
      const GridSpec g = slice::footprint_grid(l, pitch_mm);
      grid = grid ? united(*grid, g) : g;
    }
  if (!grid) throw std::invalid_argument("the paths hold no line that deposits");
  const int margin = int(std::ceil(margin_mm / pitch_mm));
  grid->nx += 2 * margin;
  grid->ny += 2 * margin;
  grid->origin_x_mm -= margin * pitch_mm;
  grid->origin_y_mm -= margin * pitch_mm;
  check(*grid);
  NominalPart part{HeightMap(*grid, 0.0), Mask(*grid)};
  for (const slice::LayerPaths& l : paths.layers) {
    if (!deposits(l)) continue;
    const double height_mm = l.height * geometry::kMmPerUnit;
    const Grid<std::uint8_t> materials = slice::footprint_materials(l, *grid);
    for (std::size_t c = 0; c < materials.size(); ++c)
      if (materials.cells[c] == 1 || (of == NominalOf::kPartAndScaffold && materials.cells[c] != 0)) {
        part.target.cells[c] += height_mm;
        part.mask.cells[c] = 1;
      }
  }
  return part;
}

}  // namespace firn::replay
