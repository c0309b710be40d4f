// Samples exact shapes of drawings so densely that the planner recognises arcs as arcs and follows splines to
// a nanometre: no rounding, no chord that deviates by more than kShapeSagitta_mm. Arcs and Bezier curves are
// returned as such, too.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "core/path/given_curve.h"

namespace firn {

inline constexpr double kShapeSagitta_mm = 2e-3, kShapeChord_mm = 0.4;
inline constexpr int kMinArcPoints = 8, kMaxArcPoints = 100000;

/// Number of points for a shape of so many chords. Not a number counts as few.
inline int shape_points(double chords) {
  return chords > kMinArcPoints ? int(std::ceil(std::min(chords, double(kMaxArcPoints)))) : kMinArcPoints;
}

/// True if both ends of an arc lie on one circle, within the rounding of a file's coordinates.
inline bool arc_radii_agree(double start_mm, double end_mm) {
  constexpr double kRound_mm = 0.01;
  return start_mm > 0.0 && std::abs(start_mm - end_mm) <= kRound_mm + 1e-3 * start_mm;
}

/// Centre of the arc through both ends that a file with rounded coordinates means: the nearest one of equal
/// radii. None where that would be another arc: a long one whose ends are near each other, or one as short as
/// the rounding.
inline std::optional<Point2> exact_centre(Point2 from, Point2 to, Point2 centre, double side) {
  if (from == to) return centre;
  const double chord = distance(from, to), ux = (to.x_mm - from.x_mm) / chord,
               uy = (to.y_mm - from.y_mm) / chord;
  const double x = centre.x_mm - 0.5 * (from.x_mm + to.x_mm), y = centre.y_mm - 0.5 * (from.y_mm + to.y_mm);
  const double off = x * ux + y * uy;
  const bool beyond_half = side * (x * uy - y * ux) > 0.0;  // the centre lies on the arc's side of its chord
  constexpr double kRounding_mm = 1e-9, kShare = 0.2;
  const double r0 = distance(centre, from), r1 = distance(centre, to);
  const double most = beyond_half ? std::max(kRounding_mm, 2.0 * std::abs(r0 - r1)) : kShare * r0;
  if (std::abs(off) > most) return std::nullopt;
  return Point2{centre.x_mm - off * ux, centre.y_mm - off * uy};
}

/// Points after `from` up to and with `to` on the arc about `centre`. @param side 1 anticlockwise, -1
/// clockwise; equal ends are a full circle. Returns the centre (exact_centre), or nothing where the radius
/// goes linearly from one end's to the other's.
template <class Add>
std::optional<Point2> sample_arc(Point2 from, Point2 to, Point2 centre, double side, Add&& add) {
  const std::optional<Point2> exact = exact_centre(from, to, centre, side);
  if (exact) centre = *exact;
  const double r0 = distance(centre, from), r1 = exact ? r0 : distance(centre, to);
  const double start = std::atan2(from.y_mm - centre.y_mm, from.x_mm - centre.x_mm);
  double turn = side * (std::atan2(to.y_mm - centre.y_mm, to.x_mm - centre.x_mm) - start);
  if (turn < 0.0) turn += 2.0 * std::numbers::pi;
  if (from == to) turn = 2.0 * std::numbers::pi;
  const double chord = std::min(kShapeChord_mm, std::sqrt(8.0 * r0 * kShapeSagitta_mm));
  const int n = shape_points(turn * r0 / chord);
  for (int i = 1; i < n; ++i) {
    const double x = double(i) / n, r = r0 + x * (r1 - r0), angle = start + side * x * turn;
    add(Point2{centre.x_mm + r * std::cos(angle), centre.y_mm + r * std::sin(angle)});
  }
  add(to);
  return exact;
}

/// Appends an arc to the given curves of a path, whose points from `first` to `last` are its samples.
inline void give_arc(std::optional<Point2> centre, double side, std::size_t first, std::size_t last,
                     std::vector<GivenCurve>& given) {
  if (!centre || first >= last) return;
  GivenCurve arc;
  arc.first = first;
  arc.last = last;
  arc.centre = *centre;
  arc.clockwise = side < 0.0;
  given.push_back(arc);
}

/// True for a Bezier curve that is the line from a to d, which drawing programs write often.
inline bool is_line(Point2 a, Point2 b, Point2 c, Point2 d) {
  constexpr double kOff_mm = 1e-9;
  const double length = distance(a, d), ux = d.x_mm - a.x_mm, uy = d.y_mm - a.y_mm;
  const auto along = [&](Point2 p) { return ux * (p.x_mm - a.x_mm) + uy * (p.y_mm - a.y_mm); };
  const auto off = [&](Point2 p) { return std::abs(ux * (p.y_mm - a.y_mm) - uy * (p.x_mm - a.x_mm)); };
  const double first = along(b), second = along(c);
  return off(b) <= kOff_mm * length && off(c) <= kOff_mm * length && 0.0 <= first && first <= second &&
         second <= length * length && length > 0.0;
}

/// Points after a up to and with d on the cubic Bezier curve. Returns their number, 0 for a line.
template <class Add>
int sample_bezier(Point2 a, Point2 b, Point2 c, Point2 d, Add&& add) {
  constexpr double kChord_mm = 0.15;
  if (is_line(a, b, c, d)) {
    add(d);
    return 0;
  }
  const double length = distance(a, b) + distance(b, c) + distance(c, d);
  const int n = shape_points(length / kChord_mm);
  for (int i = 1; i < n; ++i) {
    const double x = double(i) / n, y = 1.0 - x;
    const double w[4] = {y * y * y, 3.0 * y * y * x, 3.0 * y * x * x, x * x * x};
    add(Point2{w[0] * a.x_mm + w[1] * b.x_mm + w[2] * c.x_mm + w[3] * d.x_mm,
               w[0] * a.y_mm + w[1] * b.y_mm + w[2] * c.y_mm + w[3] * d.y_mm});
  }
  add(d);
  return n;
}

/// The same as give_arc() for a Bezier curve of so many samples, unless one of them was dropped. A line is
/// given by its ends.
inline void give_bezier(Point2 a, Point2 b, Point2 c, Point2 d, int samples, std::size_t first,
                        std::size_t last, std::vector<GivenCurve>& given) {
  if (samples == 0 || last != first + std::size_t(samples)) return;
  GivenCurve curve;
  curve.kind = GivenCurve::Kind::kBezier;
  curve.first = first;
  curve.last = last;
  curve.start = a;
  curve.control[0] = b;
  curve.control[1] = c;
  curve.end = d;
  given.push_back(curve);
}

}  // namespace firn
