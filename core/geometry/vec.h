// Vec holds points and directions of the plane in doubles, points in units of kMmPerUnit.
#pragma once

#include <cmath>

#include "core/geometry/region.h"

namespace firn::geometry {

struct Vec {
  double x = 0.0, y = 0.0;
};

inline Vec operator+(Vec a, Vec b) { return {a.x + b.x, a.y + b.y}; }
inline Vec operator-(Vec a, Vec b) { return {a.x - b.x, a.y - b.y}; }
inline Vec operator*(double s, Vec a) { return {s * a.x, s * a.y}; }
inline double dot(Vec a, Vec b) { return a.x * b.x + a.y * b.y; }
inline double cross(Vec a, Vec b) { return a.x * b.y - a.y * b.x; }  ///< > 0: b lies left of a
inline double length(Vec a) { return std::sqrt(dot(a, a)); }
inline Vec left_of(Vec a) { return {-a.y, a.x}; }
inline Vec right_of(Vec a) { return {a.y, -a.x}; }

/// Returns the square of the distance of p from the segment from a to b.
inline double square_distance(Vec p, Vec a, Vec b) {
  const Vec way = b - a, off = p - a;
  const double square = dot(way, way), along = dot(off, way);
  if (along <= 0 || square == 0) return dot(off, off);
  if (along >= square) return dot(p - b, p - b);
  const double side = cross(way, off);
  return side * side / square;
}

inline Vec to_vec(Point p) { return {double(p.x), double(p.y)}; }
inline std::int32_t floor_of(double v) {  // std::floor is a call on plain x86-64
  const auto i = std::int32_t(v);
  return i - (v < double(i));
}
inline Point to_point(Vec v) { return {floor_of(v.x + 0.5), floor_of(v.y + 0.5)}; }

}  // namespace firn::geometry
