// svg::Pen draws the path data and basic shapes of SVG 1.1 (chapters 8 and 9) as points in mm.
#pragma once

#include <functional>
#include <stdexcept>
#include <string_view>

#include "files/path/plane_transform.h"

namespace firn::svg {

/// The fault of an attribute; the reader adds file and line.
struct SyntaxError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Receives lines, Bezier curves and arcs of circles in mm, each from the point before.
struct Target {
  std::function<void(Point2)> begin, line;
  std::function<void(Point2 b, Point2 c, Point2 d)> cubic;
  std::function<void(Point2 centre, double side, Point2 to)> arc;  ///< side 1 anticlockwise, -1 clockwise
};

/// Draws in the user's units.
class Pen {
 public:
  Pen(const PlaneTransform& to_mm, const Target& target);
  void move(Point2 p);
  void line(Point2 p);
  void cubic(Point2 b, Point2 c, Point2 d);
  /// An elliptic arc (appendix F.6): radii, turn of its x axis [degrees], the larger part, anticlockwise in
  /// the user's frame with y downwards = sweep false. One of a circle stays one where the transform does not
  /// distort it; others are Bezier curves within kCubicError_mm (files/path/bezier_pieces.h).
  void arc(double rx, double ry, double turn_deg, bool large, bool sweep, Point2 to);
  void close();
  Point2 at() const { return at_; }

 private:
  void begin();
  const PlaneTransform& to_mm_;
  const Target& target_;
  Point2 at_, start_;
  double scale_ = 1.0;  ///< bound of the transform's largest scale [mm per unit]
  double turns_ = 0.0;  ///< where circles stay circles: 1, or -1 if the sense of a turn changes; otherwise 0
  bool open_ = false;
};

/// Path data: M L H V C S Q T A Z, absolute and relative. @throws SyntaxError naming the place in the data
void draw_path(std::string_view data, Pen& pen);
void draw_polygon(std::string_view points, bool closed, Pen& pen);
void draw_ellipse(Point2 centre, double rx, double ry, Pen& pen);
/// @param rx, ry radii of the corners, at most half of the sides; 0 = sharp
void draw_rect(Point2 corner, double w, double h, double rx, double ry, Pen& pen);

}  // namespace firn::svg
