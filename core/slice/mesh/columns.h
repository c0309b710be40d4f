// columns() computes the material geometry M of two-ink printing: the intervals of vertical lines inside a
// mesh.
#pragma once

#include <cstdint>
#include <vector>

#include "core/geometry/rtree.h"
#include "core/grid/geometry.h"
#include "core/slice/mesh/mesh.h"

namespace firn::slice {

/// Returns per cell of `grid` the intervals of height within [0, height_mm] in which the centre of the cell
/// lies inside the mesh, where the winding number is positive. Exact: one line per cell, at most a unit of
/// the grid beside its centre so that it meets no vertex, intersects each facet by integer orientation tests,
/// and the ends of the intervals are the heights of the facets there. Linear in facets and crossings.
std::vector<std::vector<Span>> columns(const Mesh& mesh, const GridSpec& grid, double height_mm);

/// MeshSolid computes the same for single points.
class MeshSolid final : public Solid {
 public:
  explicit MeshSolid(Mesh mesh);
  bool contains(double x_mm, double y_mm, double z_mm) const override;

 private:
  Mesh mesh_;
  geometry::StaticRTree tree_;  // shadows of the facets on the x-y plane
};

}  // namespace firn::slice
