// A mesh as the geometry M of two-ink printing: what a vertical line through each cell of a grid meets.
#pragma once

#include <cstdint>
#include <vector>

#include "core/grid/geometry.h"
#include "core/slice/mesh/mesh.h"

namespace firn::slice {

/// Per cell of `grid` the heights within [0, height_mm] at which the cell's centre lies inside the mesh:
/// where the winding number is positive. Exact: one line per cell, at most a unit of the grid beside its
/// centre so that it meets no vertex, meets each facet by integer orientation tests, and the ends of the
/// spans are the facets' own heights there. Linear in facets and crossings.
std::vector<std::vector<Span>> columns(const Mesh& mesh, const GridSpec& grid, double height_mm);

/// The same question for any point, for whoever asks one by one.
class MeshSolid final : public Solid {
 public:
  explicit MeshSolid(Mesh mesh);
  bool contains(double x_mm, double y_mm, double z_mm) const override;

 private:
  std::int64_t cell_x(std::int64_t x) const;
  std::int64_t cell_y(std::int64_t y) const;

  Mesh mesh_;
  std::vector<std::uint32_t> first_, facets_;  // facets whose box meets each cell of a raster over x and y
  Vertex low_, high_;
  std::int64_t side_ = 1;  // cells of the raster along each axis
};

}  // namespace firn::slice
