// GapBand holds the width of the band between two offset levels; GapLimits holds the distances within which
// it has no void.
#pragma once

#include "core/slice/medial/medial_axis.h"
#include "core/slice/ring_plan.h"

namespace firn::slice {

/// The band between one level of rings (or the outline) and the next, in mm inward of the former.
struct GapBand {
  /// Reach of the lines of the outer level; < 0: the wanted area begins outside the outline.
  double covered_mm = 0.0;
  /// Distance of the next level, whose lines reach next_mm - covered_mm to each side.
  double next_mm = 0.0;
  double inside_mm = 0.0;  ///< distance of the given rings from that level
};
/// @param level of the outer rings; -1: the outline itself, whose wanted area is that of coverage.h
GapBand gap_band(const RingPlan& plan, int level);
/// The same from the eroded core of a level (RingPlan::eroded_core_mm): every disc of that diameter touches
/// the covered area there.
GapBand eroded_core_band(const RingPlan& plan, int level, double void_mm);

/// A band in units. A void that touches the covered edge in a boundary sample has its centre `void_at` inward
/// of the sample.
///
/// Let y be the point of the next level nearest to the centre x of a void of radius s, delta <= n the depth
/// of x and p its boundary sample. No outline is nearer to y than n, so |p - y| >= n; |x - y| >= D = n -
/// covered + s; and the square of the distance from y along the segment from x to p is convex, with second
/// derivative 2. At depth c = covered + s on that segment it is therefore at least D^2 - (delta - c) (D^2 +
/// delta^2 - n^2) / delta + (delta - c)^2, whose minimum over c <= delta <= n is at one of the ends: D^2 or
/// (n - c)^2 + D^2 c / n. A sample whose point at that depth is nearer has no void (`enough`).
///
/// Where y is known to be P and no boundary segment crosses the line from P to x, the segment behind x on
/// that line is at least D + c = n + 2 s from P (`far`).
struct GapLimits {
  MedialLimits axis;
  double void_at = 0;
  double enough = 0;
  /// Maximum distance of the next level from a point that it serves.
  double near = 0;
  /// The same for all points of a chain for which one point of the next level is the nearest.
  double far = 0;
  /// The same for a corner of two segments, whose voids lie on the straight line to the next level.
  double near_corner = 0;
  double slack = 0;  ///< points so far outside such a corner count as inside
};
GapLimits gap_limits(const GapBand& band, double void_mm, double tolerance_mm);

}  // namespace firn::slice
