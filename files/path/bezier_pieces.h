// cubic_pieces() computes the cubic Bezier curves of a span of a B-spline: the span itself where it is cubic
// or lower and not rational, otherwise curves within a proved distance of it.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/path/path.h"

namespace firn {

using CubicBezier = std::array<Point2, 4>;

/// Largest distance between a curve that is not cubic and the Bezier curves that replace it.
inline constexpr double kCubicError_mm = 1e-6;

/// A control point of a rational Bezier curve, weighted: w x, w y, w.
struct WeightedPoint {
  double x = 0.0, y = 0.0, w = 1.0;
  Point2 point() const { return {x / w, y / w}; }
};

/// Appends the pieces of the Bezier curve with these control points. False, with nothing appended, where
/// kCubicError_mm would need more than 1024 pieces.
/// @pre 3 to 16 control points, weights above 0
///
/// With N and w the curve's numerator and denominator and C a piece, |N / w - C| <= max |b| / min w over the
/// control points b of the polynomial N - C w and those of w.
bool cubic_pieces(std::span<const WeightedPoint> control, std::vector<CubicBezier>& pieces);

/// Number of cubic Bezier curves of equal angle for a whole turn about an ellipse with this larger radius:
/// each is within 2/27 sin^6(a/4) / cos^2(a/4) radii of its arc of angle a [Goldapp 1991], here
/// kCubicError_mm.
int ellipse_pieces(double radius_mm);

}  // namespace firn
