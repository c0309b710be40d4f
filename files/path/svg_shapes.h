// svg::Pen draws the path data, transforms and basic shapes of SVG 1.1 (chapters 7 to 9) as points in mm.
#pragma once

#include <functional>
#include <span>
#include <stdexcept>
#include <string_view>

#include "core/path/path.h"

namespace firn::svg {

/// The fault of an attribute; the reader adds file and line.
struct SyntaxError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// x' = a x + c y + e, y' = b x + d y + f.
struct Transform {
  double a = 1.0, b = 0.0, c = 0.0, d = 1.0, e = 0.0, f = 0.0;
  Point2 operator()(Point2 p) const { return {a * p.x_mm + c * p.y_mm + e, b * p.x_mm + d * p.y_mm + f}; }
  /// First `first`, then this one.
  Transform operator*(const Transform& first) const;
};

/// The value of a transform attribute: matrix, translate, scale, rotate, skewX, skewY. @throws SyntaxError
Transform transform(std::string_view text);

/// A length with its unit: mm, cm, in, pt, pc, px or none (1/96 inch). @throws SyntaxError
double length_mm(std::string_view text);

/// As many numbers as `out` has, with blanks or commas between them. @throws SyntaxError
void numbers(std::string_view text, std::span<double> out);

/// Receives lines, Bezier curves and arcs of circles in mm, each from the point before.
struct Target {
  std::function<void(Point2)> begin, line;
  std::function<void(Point2 b, Point2 c, Point2 d)> cubic;
  std::function<void(Point2 centre, double side, Point2 to)> arc;  ///< side 1 anticlockwise, -1 clockwise
};

/// Draws in the user's units.
class Pen {
 public:
  Pen(const Transform& to_mm, const Target& target);
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
  const Transform& to_mm_;
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
