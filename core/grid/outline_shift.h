// OutlineShift computes how far a measured deposit lies from where it was laid.
#pragma once

#include "core/grid/grid.h"

namespace firn {

/// The shift of the map against the outline. A shift of the sensor or of the nozzle shows in one map alike.
struct OutlineShift {
  bool known = false;  ///< enough cells on either side of the outline were measured
  double x_mm = 0.0, y_mm = 0.0;
  double rise_mm = 0.0;  ///< of the deposit there
  double gain = 0.0;     ///< share of the squared residual of no shift that this shift explains, 0 to 1
};

/// Least squares over shifts s by whole cells: minimises the sum of (rise(c) - h laid(c - s) - k beside(c))^2
/// over the measured cells within `reach_mm` of the outline, h and k being the best heights for each s; a
/// parabola through the neighbours gives the fraction of a cell. Sums run in index order, so equal input
/// gives equal bytes.
/// @param rise of the surface [mm]; NaN: not measured
/// @param laid 1 where material was laid
/// @param beside 1 where other material was laid, which stays in its place; empty: nothing
/// @param reach_mm largest shift looked for, along each axis
/// @throws std::invalid_argument: sizes that differ
OutlineShift outline_shift(const HeightMap& rise, const Mask& laid, const Mask& beside, double reach_mm);

/// Height by which the edge at maximum x (y) is lower than that at minimum x (y), in widths of a cell: where
/// readings lie on the part alone, a sensor that is aside reads bare ground at one edge.
struct EdgeGap {
  bool known = false;  ///< enough cells on each edge
  double x_mm = 0.0, y_mm = 0.0;
  double x_std_mm = 0.0, y_std_mm = 0.0;  ///< standard error, of independent cells
};

/// @param rise of the surface [mm]; NaN: not measured, beside the part
EdgeGap edge_gap(const HeightMap& rise);

}  // namespace firn
