// ScatteredSurface computes the surface through scattered points, linear on each triangle of their Delaunay
// triangulation: Barnett's TRISCATTEREDINTERP [Barnett 2012, 5.2.1].
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/grid/grid.h"

namespace firn::surface {

struct SurfacePoint {
  double x_mm = 0.0, y_mm = 0.0, z_mm = 0.0;
};

/// Triangulated by OpenCV's Subdiv2D. Points that coincide (within its single precision, some 0.01 um at 100
/// mm) count as one with their mean height. Reproduces planes exactly, and every point's height at the point.
/// Deterministic for a given order of points; neighbours in the order should be neighbours in place, as along
/// a path: then a point costs little.
class ScatteredSurface {
 public:
  /// Points with a coordinate that is not finite are left out. @throws std::invalid_argument: a coordinate
  /// beyond 10 m of the first point's
  explicit ScatteredSurface(std::span<const SurfacePoint> points);
  ~ScatteredSurface();
  ScatteredSurface(ScatteredSurface&&) noexcept;

  /// Height at a point; NaN outside the convex hull of the points, and everywhere with fewer than three that
  /// span a triangle. (A hull edge of length L may lie L^2 / 8e5 mm inside the true hull's.)
  double at(double x_mm, double y_mm);
  /// The same for every cell: at its centre, or the mean of those of samples x samples equal parts of it that
  /// have one.
  HeightMap on(const GridSpec& grid, int samples = 1);
  std::size_t points() const;  ///< distinct ones

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Cells that are not finite take the value of their nearest finite one (by rings of eight neighbours). With
/// no finite cell nothing changes.
void fill_from_nearest(HeightMap& height);

}  // namespace firn::surface
