// Computes analytic target geometries on a grid: desired height per cell and the mask of cells that belong to
// the part.
#pragma once

#include <string>
#include <vector>

#include "core/grid/grid.h"

namespace firn {

struct Target {
  HeightMap height;  ///< desired height h_d [mm], 0 outside the mask [Lu 2015, Eq. (8); a matrix, see errata]
  Mask mask;
};

/// Sizes in mm, centred on the grid. Fields a shape does not use are ignored.
struct ShapeSpec {
  std::string kind = "cylinder";  ///< see shape_kinds()
  double height_mm = 0.4;
  double diameter_mm = 10.0;       ///< cylinder, pipe (outer), cone, dome (base)
  double inner_diameter_mm = 0.0;  ///< pipe
  double width_mm = 0.0;           ///< cuboid, wedge: along x
  double depth_mm = 0.0;           ///< cuboid, wedge: along y
  double low_height_mm = 0.0;      ///< wedge: height at its low (-x) end; cone: height of its flat top's rim
};

inline constexpr OptionTable kShapeSpec{
    Option{"height_mm", &ShapeSpec::height_mm, "mm", above(0, 1000),
           "height of the part (wedge: of its high end)"},
    Option{"diameter_mm", &ShapeSpec::diameter_mm, "mm", within(0, 1e4),
           "cylinder, pipe, cone, dome: (outer) diameter"},
    Option{"inner_diameter_mm", &ShapeSpec::inner_diameter_mm, "mm", within(0, 1e4), "pipe: inner diameter"},
    Option{"width_mm", &ShapeSpec::width_mm, "mm", within(0, 1e4),
           "cuboid, wedge: size along x; height_map: of the picture, whose depth follows from its aspect"},
    Option{"depth_mm", &ShapeSpec::depth_mm, "mm", within(0, 1e4), "cuboid, wedge: size along y"},
    Option{"low_height_mm", &ShapeSpec::low_height_mm, "mm", within(0, 1000),
           "wedge: height of its low end; cone: of its rim"},
};

const std::vector<std::string>& shape_kinds();

/// @throws std::invalid_argument naming the size that is out of its range
void check(const ShapeSpec& shape);

/// A cell belongs to the part when its centre lies inside the outline (boundary included).
/// @throws std::invalid_argument naming the field and limit: unknown kind, size not positive, part empty on
/// this grid, inner diameter not below outer.
Target make_shape(const ShapeSpec& shape, const GridSpec& grid);

}  // namespace firn
