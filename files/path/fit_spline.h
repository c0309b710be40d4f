// fit_spline() computes the cubic spline through points that a drawing program shows for a curve given by fit
// points.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "files/path/bezier_pieces.h"

namespace firn {

/// Direction of the curve at an open end; its length does not matter.
struct EndTangents {
  std::optional<Point2> start, end;
};

/// Returns one Bezier curve for each interval of the interpolating cubic spline with continuous second
/// derivative over the chord length [de Boor 1978, ch. 4]. An end without a tangent is natural: its second
/// derivative is 0. A closed spline is periodic. Equal points in sequence count once; fewer than two points
/// have no curve.
std::vector<CubicBezier> fit_spline(std::span<const Point2> points, bool closed, const EndTangents& tangents);

}  // namespace firn
