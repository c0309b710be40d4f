#include "core/grid/shapes.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/options/range.h"

namespace firn {
namespace {

void positive(double value, const char* field) {
  if (!(std::isfinite(value) && value > 0.0))
    throw std::invalid_argument(std::string("part: ") + field + " = " + std::to_string(value) +
                                " must be above 0");
}

}  // namespace

const std::vector<std::string>& shape_kinds() {
  static const std::vector<std::string> kinds = {"cylinder", "pipe", "cone", "dome", "cuboid", "wedge"};
  return kinds;
}

void check(const ShapeSpec& shape) { check_options("part", kShapeSpec, shape); }

Target make_shape(const ShapeSpec& shape, const GridSpec& grid) {
  check(grid);
  const auto& kinds = shape_kinds();
  if (std::find(kinds.begin(), kinds.end(), shape.kind) == kinds.end()) {
    std::string all;
    for (const auto& k : kinds) all += (all.empty() ? "" : ", ") + k;
    throw std::invalid_argument("part: shape '" + shape.kind + "' is not one of " + all);
  }
  check(shape);
  const bool box = shape.kind == "cuboid" || shape.kind == "wedge";
  if (box) {
    positive(shape.width_mm, "width_mm");
    positive(shape.depth_mm, "depth_mm");
  } else {
    positive(shape.diameter_mm, "diameter_mm");
  }
  if (shape.kind == "pipe" && !(shape.inner_diameter_mm > 0.0 && shape.inner_diameter_mm < shape.diameter_mm))
    throw std::invalid_argument("part: inner_diameter_mm = " + shortest_text(shape.inner_diameter_mm) +
                                " must lie between 0 and diameter_mm");

  if (!(shape.low_height_mm >= 0.0 && shape.low_height_mm <= shape.height_mm))
    throw std::invalid_argument("part: low_height_mm = " + shortest_text(shape.low_height_mm) +
                                " must lie between 0 and height_mm");

  const double cx = 0.5 * (grid.x_mm(0) + grid.x_mm(grid.nx - 1)),
               cy = 0.5 * (grid.y_mm(0) + grid.y_mm(grid.ny - 1));
  const double slack = 1e-9 * (grid.pitch_x_mm + grid.pitch_y_mm);  // a centre on the outline is inside
  const double radius = 0.5 * shape.diameter_mm + slack;
  Target t{HeightMap(grid), Mask(grid)};
  for (int j = 0; j < grid.ny; ++j)
    for (int i = 0; i < grid.nx; ++i) {
      const double x = grid.x_mm(i) - cx, y = grid.y_mm(j) - cy, r = std::sqrt(x * x + y * y);
      bool inside =
          box ? std::abs(x) <= 0.5 * shape.width_mm + slack && std::abs(y) <= 0.5 * shape.depth_mm + slack
              : r <= radius;
      if (shape.kind == "pipe") inside = inside && r >= 0.5 * shape.inner_diameter_mm - slack;
      if (!inside) continue;
      double h = shape.height_mm;
      const double rho = std::min(1.0, 2.0 * r / shape.diameter_mm);
      if (shape.kind == "cone")
        h = shape.low_height_mm + (shape.height_mm - shape.low_height_mm) * (1.0 - rho);
      if (shape.kind == "dome") h = shape.height_mm * std::sqrt(1.0 - rho * rho);
      if (shape.kind == "wedge")
        h = shape.low_height_mm +
            (shape.height_mm - shape.low_height_mm) * std::clamp(x / shape.width_mm + 0.5, 0.0, 1.0);
      t.height.at(i, j) = h;
      t.mask.at(i, j) = 1;
    }
  if (t.mask.count() == 0)
    throw std::invalid_argument("part: no cell centre of the grid lies inside the part");
  return t;
}

}  // namespace firn
