// measure_offset() estimates the offset of the second nozzle from the first by the height map of a
// registration print.
#pragma once

#include <vector>

#include "core/grid/grid.h"
#include "core/grid/material.h"

namespace firn::registration {

/// Where a mark was meant to be, and whose it is. The grid's cell nearest to it is the middle of its search.
struct MarkSite {
  double x_mm = 0.0, y_mm = 0.0;
  Material material = Material::kA;
};

/// An estimate with its standard error and the half width of its 95 % interval.
struct Interval {
  double value_mm = 0.0, sigma_mm = 0.0, ci95_half_width_mm = 0.0;
};

struct NozzleOffset {
  Interval x, y;                 ///< how far B's marks lie from where they were meant, more than A's do
  int marks_a = 0, marks_b = 0;  ///< that counted
  int skipped = 0;               ///< with less than half of the usual volume
};

/// The marks' centres of mass in after - before: first the common shift of each nozzle's marks, in whole
/// cells up to 0.35 x the marks' least distance; then, mark by mark, the centre of mass [sum h x / sum h, sum
/// h y / sum h] in a window of +-0.34 x that distance about it, heights above the mean of the ground outside
/// all windows. The offset is the difference of the two nozzles' mean displacements. Its standard error comes
/// from the marks' own scatter, the interval from Student's t with Welch's degrees of freedom: sensor noise,
/// placement and droplet sizes are all in it; a magnification or a rotation of the map is not, but cancels
/// with marks that alternate. Heights that are not finite count as ground.
/// @throws std::invalid_argument: maps of different grids; fewer than four marks of a nozzle that count; a
/// nozzle whose marks are not found within the search (says which)
NozzleOffset measure_offset(const HeightMap& before, const HeightMap& after,
                            const std::vector<MarkSite>& marks);

}  // namespace firn::registration
