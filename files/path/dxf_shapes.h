// dxf::sample() computes points [mm] of the curve entities of a DXF drawing, with the arcs and Bezier curves
// among them. Ellipses and splines that are not cubic are Bezier curves within kCubicError_mm
// (files/path/bezier_pieces.h).
#pragma once

#include <span>
#include <stdexcept>
#include <vector>

#include "files/path/join_curves.h"

namespace firn::dxf {

/// The fault of an entity; the reader adds file and line.
struct ShapeError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A vertex of a polyline. Bulge: tan of a quarter of the angle of the arc to the next vertex, > 0
/// anticlockwise.
struct Vertex {
  Point2 at;
  double bulge = 0.0;
};

/// A rational B-spline (NURBS) [Piegl, Tiller 1997, ch. 4].
struct Spline {
  int degree = 3;
  std::vector<double> knots;    ///< control + degree + 1, ascending
  std::vector<Point2> control;  ///< degree + 1 or more
  std::vector<double> weights;  ///< one per control point, above 0; empty = all 1
};

// Each appends to `out`, which is empty before. Angles in degrees, anticlockwise. @throws ShapeError naming
// the limit: radii above 0, sizes that fit, at most kMaxPathPoints points.
void sample(std::span<const Vertex> polyline, bool closed, ShapedPoints& out);
void sample_arc(Point2 centre, double radius_mm, double from_deg, double to_deg, ShapedPoints& out);
/// @param major from the centre to the end of the major axis; the ellipse runs from parameter `from` to `to`
/// [rad] anticlockwise, clockwise if mirrored
void sample_ellipse(Point2 centre, Point2 major, double ratio, double from, double to, bool mirrored,
                    ShapedPoints& out);
void sample(const Spline& spline, ShapedPoints& out);

}  // namespace firn::dxf
