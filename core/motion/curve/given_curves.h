// given_between() and sample_given() compute the parts of given curves (core/path/given_curve.h) between two
// points of a path, and a polygon that follows them more closely than the path's points do.
#pragma once

#include <span>
#include <vector>

#include "core/motion/curve/constants.h"
#include "core/path/given_curve.h"

namespace firn::motion {

/// Parts of the curves between two points of the path; indices count from `from`.
void given_between(std::span<const GivenCurve> given, std::size_t from, std::size_t to,
                   std::vector<GivenCurve>& out);

/// Unit tangent and curvature of a path on one side of a point: of the given curve there, or of the chord.
struct PathDirection {
  Point2 tangent;
  double curvature = 0.0;  ///< 1/mm, > 0 turns left
};

/// @param after towards the next point, otherwise from the one before. @pre there is such a point; point i is
/// no inner sample of a given curve
PathDirection direction_at(std::span<const Point2> points, std::span<const GivenCurve> given, std::size_t i,
                           bool after);

/// Polygon that stands for a path with given curves.
struct GivenReference {
  std::span<const Point2> points;
  double sagitta_mm = 0.0;  ///< bound of its distance from the curves, both ways; 0 without any
};

/// The points with further ones on the given curves between them: in `buffer`, or `points` themselves where
/// no curve is given. @param given ascending, within `points`
GivenReference sample_given(std::span<const Point2> points, std::span<const GivenCurve> given,
                            std::vector<Point2>& buffer);

}  // namespace firn::motion
