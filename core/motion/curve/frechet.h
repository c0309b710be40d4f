// frechet_bound() computes an upper bound of the Frechet distance between a curve and the polygon that it
// follows: no two-way walk along both, in which neither turns back, needs to be further apart than that.
//
// A correspondence is chosen: each vertex goes with a parameter of the curve, none before the vertex before
// it, and between two vertices the polygon is linear in the parameter. Any correspondence gives a bound. In
// every cell, cut at the vertices, curve minus polygon is a cubic in the parameter: it lies in the hull of
// its Bezier points, which are divided until the bound is sharp.
#pragma once

#include <span>
#include <vector>

#include "core/motion/curve/path_curve.h"

namespace firn::motion {

/// Returns the bound in mm; it exceeds the largest distance within the correspondence by at most 1 % and
/// 1e-6 mm. Infinite for a curve without length: no motion follows it.
double frechet_bound(const Curve& curve, std::span<const Point2> points);

/// Part of a curve that is further from the polygon than a limit.
struct StretchBeyond {
  double from = 0.0, to = 0.0;  ///< parameters of the curve
  double beyond_mm = 0.0;       ///< bound of the distance, less the limit
};

/// Finds all of them, in order; together they contain every place where frechet_bound() is beyond the limit.
void find_stretches_beyond(const Curve& curve, std::span<const Point2> points, double limit_mm,
                           std::vector<StretchBeyond>& found);

/// Largest distance of one of `points` from the place of the curve that goes with it, none before that of the
/// point before it: of the nearest places those in order that are nearest to them.
/// @param within_mm how far the points may be off: so far one may lie behind the one before it
double farthest_point_mm(const Curve& curve, std::span<const Point2> points, double within_mm);

}  // namespace firn::motion
