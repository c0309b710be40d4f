// How wide the band between two levels is, and how far apart what of it may be that holds no spot worth a
// bead.
#pragma once

#include "core/slice/medial/middle_lines.h"
#include "core/slice/ring_plan.h"

namespace firn::slice {

/// What lies between one level of rings (or the outline) and the next, in mm inward of the former.
struct GapBand {
  double covered_mm =
      0.0;  ///< so far the beads of the outer level reach; < 0: the wanted area begins outside the outline
  double next_mm =
      0.0;  ///< there the next level runs, half as wide a bead as is left: next_mm - covered_mm to each side
  double inside_mm = 0.0;  ///< so far the rings that are given lie inward of that level
};
/// @param level of the outer rings; -1: the outline itself, whose wanted area is that of coverage.h
GapBand gap_band(const RingPlan& plan, int level);
/// The same from a level's cores (RingPlan::core_mm) on: every disc of that diameter touches what is covered
/// there.
GapBand core_band(const RingPlan& plan, int level, double spot_mm);

/// A band in units. A spot that touches the covered edge in a foot has its centre `spot_at` inward of that
/// foot.
///
/// Let y be the place of the next level nearest to the centre x of an uncovered spot of radius s, delta <= n
/// the depth of x and p its foot. No outline is nearer to y than n, so |p - y| >= n; |x - y| >= D = n -
/// covered + s; and the square of the distance from y along the way from x to p is convex, with second
/// derivative 2. At depth c = covered + s on that way it is therefore at least D^2 - (delta - c) (D^2 +
/// delta^2 - n^2) / delta + (delta - c)^2, which over c <= delta <= n is least at one of the ends: D^2 or (n
/// - c)^2 + D^2 c / n. A foot whose place at that depth is nearer has no spot (`enough`).
///
/// Where y is known to be P and no wall crosses the way from P to x, the wall behind x on that way is at
/// least D + c = n + 2 s from P (`far`).
struct GapLimits {
  AxisLimits axis;
  double spot_at = 0;
  double enough = 0;
  double near = 0;  ///< how far the next level may be from a place that does not lack it
  double far =
      0;  ///< the same from all places of a stretch where the next level's nearest place is one and the same
  double near_corner =
      0;  ///< the same from a corner of two walls, whose spots lie on the straight way to the next level
  double slack = 0;  ///< what lies so far outside such a corner is as good as in it
};
GapLimits gap_limits(const GapBand& band, double spot_mm, double tolerance_mm);

}  // namespace firn::slice
