// given_between() and sample_given() compute the parts of given curves (core/path/given_curve.h) between two
// points of a path, and a polygon that follows them more closely than the path's points do.
#pragma once

#include <span>
#include <vector>

#include "core/path/given_curve.h"

namespace firn::motion {

/// Parts of the curves between two points of the path; indices count from `from`.
void given_between(std::span<const GivenCurve> given, std::size_t from, std::size_t to,
                   std::vector<GivenCurve>& out);

/// Largest distance between a given curve and the polygon of sample_given().
inline constexpr double kGivenSagittaMm = 1e-5;

/// The points with further ones on the given curves between them: in `buffer`, or `points` themselves where
/// no curve is given. @param given ascending, within `points`
std::span<const Point2> sample_given(std::span<const Point2> points, std::span<const GivenCurve> given,
                                     std::vector<Point2>& buffer);

}  // namespace firn::motion
