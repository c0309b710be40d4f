// PlaneTransform is an affine map of the plane: lines stay lines, circles become ellipses. Depends on nothing
// but points.
#pragma once

#include <cmath>
#include <numbers>

#include "core/path/path.h"

namespace firn {

/// x' = a x + c y + e, y' = b x + d y + f.
struct PlaneTransform {
  double a = 1.0, b = 0.0, c = 0.0, d = 1.0, e = 0.0, f = 0.0;

  Point2 operator()(Point2 p) const { return {a * p.x_mm + c * p.y_mm + e, b * p.x_mm + d * p.y_mm + f}; }
  /// Of a difference of two points.
  Point2 direction(Point2 v) const { return {a * v.x_mm + c * v.y_mm, b * v.x_mm + d * v.y_mm}; }
  /// First `first`, then this one.
  PlaneTransform operator*(const PlaneTransform& first) const {
    const Point2 x = direction({first.a, first.b}), y = direction({first.c, first.d}),
                 origin = (*this)({first.e, first.f});
    return {x.x_mm, x.y_mm, y.x_mm, y.y_mm, origin.x_mm, origin.y_mm};
  }
  double determinant() const { return a * d - b * c; }
  /// @pre determinant() is not 0
  PlaneTransform inverse() const {
    const double k = 1.0 / determinant();
    const PlaneTransform turned{k * d, -k * b, -k * c, k * a, 0.0, 0.0};
    const Point2 back = turned.direction({e, f});
    return {turned.a, turned.b, turned.c, turned.d, -back.x_mm, -back.y_mm};
  }

  static PlaneTransform translation(double x, double y) { return {1.0, 0.0, 0.0, 1.0, x, y}; }
  static PlaneTransform scaling(double x, double y) { return {x, 0.0, 0.0, y, 0.0, 0.0}; }
  /// Turns x towards y. Quarter turns are exact.
  static PlaneTransform rotation_deg(double angle) {
    constexpr double kQuarters[4][2] = {{1.0, 0.0}, {0.0, 1.0}, {-1.0, 0.0}, {0.0, -1.0}};
    const double quarters = std::fmod(angle / 90.0, 4.0);
    double cosine = std::cos(angle * std::numbers::pi / 180.0),
           sine = std::sin(angle * std::numbers::pi / 180.0);
    if (quarters == std::floor(quarters)) {
      const double* exact = kQuarters[(int(quarters) + 4) % 4];
      cosine = exact[0];
      sine = exact[1];
    }
    return {cosine, sine, -sine, cosine, 0.0, 0.0};
  }
};

}  // namespace firn
