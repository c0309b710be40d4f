// dxf::sample() computes points [mm] of the curve entities of a DXF drawing, with the arcs and Bezier curves
// among them. Ellipses and splines that are not cubic are Bezier curves within kCubicError_mm
// (files/path/bezier_pieces.h).
#pragma once

#include <span>
#include <stdexcept>
#include <vector>

#include "files/path/bezier_pieces.h"
#include "files/path/join_curves.h"
#include "files/path/plane_transform.h"

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

/// The points centre + cos(t) first + sin(t) second for t from `from` to `to` [rad]: an arc of a circle or an
/// ellipse, by two conjugate half axes.
struct Arc {
  Point2 centre, first, second;
  double from = 0.0, to = 0.0;
  double rounding = 0.0;  ///< of `from` and `to` in the file [rad]
};

/// A rational B-spline (NURBS) [Piegl, Tiller 1997, ch. 4].
struct Spline {
  int degree = 3;
  std::vector<double> knots;    ///< control + degree + 1, ascending
  std::vector<Point2> control;  ///< degree + 1 or more [mm]
  std::vector<double> weights;  ///< one per control point, above 0; empty = all 1
};

// Each appends to `out`, which is empty before. @throws ShapeError naming the limit: sizes that fit, at most
// kMaxPathPoints points.
void sample(std::span<const Vertex> polyline, bool closed, const PlaneTransform& to_mm, ShapedPoints& out);
/// An arc is a full turn if its sweep is one within 1e-4 of a turn, or if its ends coincide within the file's
/// rounding.
void sample(const Arc& arc, const PlaneTransform& to_mm, ShapedPoints& out);
void sample(const Spline& spline, ShapedPoints& out);
/// Curves each of which begins where the one before ends.
void sample(std::span<const CubicBezier> curves, const PlaneTransform& to_mm, ShapedPoints& out);

}  // namespace firn::dxf
