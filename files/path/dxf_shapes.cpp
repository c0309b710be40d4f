#include "files/path/dxf_shapes.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "files/path/bezier_pieces.h"
#include "files/path/path_file.h"
#include "files/path/sampled_shapes.h"

namespace firn::dxf {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr double kSplineChord_mm = 0.15;
constexpr int kMaxDegree = 15;

void check(bool good, const std::string& problem) {
  if (!good) throw ShapeError(problem);
}

void add(Point2 p, std::vector<Point2>& out) {
  for (const double v : {p.x_mm, p.y_mm})
    check(std::abs(v) <= kMaxCoordinate_mm,
          fmt::format("{} mm is beyond the limit of +-{} mm", v, kMaxCoordinate_mm));
  if (!out.empty() && out.back() == p) return;
  check(out.size() < kMaxPathPoints, fmt::format("more than {} points in one path", kMaxPathPoints));
  out.push_back(p);
}

void add_arc(Point2 from, Point2 to, Point2 centre, double side, ShapedPoints& out) {
  const std::size_t first = out.points.size() - 1;
  const auto exact = firn::sample_arc(from, to, centre, side, [&](Point2 p) { add(p, out.points); });
  give_arc(exact, side, first, out.points.size() - 1, out.given);
}

void add_bezier(const CubicBezier& c, ShapedPoints& out) {
  const std::size_t first = out.points.size() - 1;
  const int samples = sample_bezier(c[0], c[1], c[2], c[3], [&](Point2 p) { add(p, out.points); });
  give_bezier(c[0], c[1], c[2], c[3], samples, first, out.points.size() - 1, out.given);
}

/// Half of an arc's major axis.
double major_radius(const Arc& arc) {
  const Point2 u = arc.first, v = arc.second;
  const double uu = u.x_mm * u.x_mm + u.y_mm * u.y_mm, vv = v.x_mm * v.x_mm + v.y_mm * v.y_mm,
               uv = u.x_mm * v.x_mm + u.y_mm * v.y_mm;
  return std::sqrt(0.5 * (uu + vv + std::hypot(uu - vv, 2.0 * uv)));
}

/// Adds the arc of `sweep` radians from its first point, which is the last one of `out`, to `end`.
void add_arc(const Arc& arc, double sweep, Point2 end, ShapedPoints& out) {
  constexpr double kAlike = 1e-12;
  const Point2 u = arc.first, v = arc.second;
  const double uu = u.x_mm * u.x_mm + u.y_mm * u.y_mm, vv = v.x_mm * v.x_mm + v.y_mm * v.y_mm,
               uv = u.x_mm * v.x_mm + u.y_mm * v.y_mm, turn = u.x_mm * v.y_mm - u.y_mm * v.x_mm;
  if (std::abs(uu - vv) <= kAlike * uu && std::abs(uv) <= kAlike * uu)
    return add_arc(out.points.back(), end, arc.centre, turn > 0.0 ? 1.0 : -1.0, out);
  const auto place = [&](double x, double y) {
    return Point2{arc.centre.x_mm + x * u.x_mm + y * v.x_mm, arc.centre.y_mm + x * u.y_mm + y * v.y_mm};
  };
  const int n = std::max(1, int(std::ceil(sweep / kTurn * ellipse_pieces(major_radius(arc)))));
  const double step = sweep / n, handle = 4.0 / 3.0 * std::tan(0.25 * step);
  for (int i = 0; i < n; ++i) {
    const double a = arc.from + i * step, b = a + step;
    add_bezier(
        {out.points.back(), place(std::cos(a) - handle * std::sin(a), std::sin(a) + handle * std::cos(a)),
         place(std::cos(b) + handle * std::sin(b), std::sin(b) - handle * std::cos(b)),
         i + 1 < n ? place(std::cos(b), std::sin(b)) : end},
        out);
  }
}

/// The same arc in the frame that the transform leads to.
Arc transformed(Arc arc, const PlaneTransform& t) {
  arc.centre = t(arc.centre);
  arc.first = t.direction(arc.first);
  arc.second = t.direction(arc.second);
  return arc;
}

void add_segment(const Vertex& from, Point2 to, const PlaneTransform& to_mm, ShapedPoints& out) {
  constexpr double kMinSagitta_mm = 1e-7;
  const Point2 a = from.at;
  const double chord_mm = distance(to_mm(a), to_mm(to)), bulge = from.bulge;
  check(std::isfinite(bulge) && std::isfinite(chord_mm), "a polyline with a number that is not finite");
  if (0.5 * std::abs(bulge) * chord_mm < kMinSagitta_mm) return add(to_mm(to), out.points);
  const double away = 0.25 * (1.0 - bulge * bulge) / bulge;  // from the chord's middle, in chords
  const Point2 centre{0.5 * (a.x_mm + to.x_mm) - away * (to.y_mm - a.y_mm),
                      0.5 * (a.y_mm + to.y_mm) + away * (to.x_mm - a.x_mm)};
  const double side = bulge > 0.0 ? 1.0 : -1.0;
  const Point2 first{a.x_mm - centre.x_mm, a.y_mm - centre.y_mm},
      second{-side * first.y_mm, side * first.x_mm};
  add_arc(transformed({centre, first, second}, to_mm), 4.0 * std::atan(std::abs(bulge)), to_mm(to), out);
}

/// The sweep of an arc, in (0, a turn].
double sweep_of(const Arc& arc) {
  constexpr double kWhole = 1e-4 * kTurn, kUnits = 1.5;
  const double difference = arc.to - arc.from, off = std::abs(std::remainder(difference, kTurn));
  double sweep = std::fmod(difference, kTurn);
  if (sweep <= 0.0) sweep += kTurn;
  const bool beyond = difference > 0.5 * kTurn || sweep > 0.5 * kTurn;
  const double ends_mm = off * std::max(distance({}, arc.first), distance({}, arc.second));
  const bool rounded = off <= kUnits * arc.rounding && ends_mm <= kJoin_mm;
  return off <= kWhole && (beyond || rounded) ? kTurn : sweep;
}

/// The blossom of the spline's piece in a span [Piegl, Tiller 1997]: de Boor's algorithm with one parameter
/// per level, here first `degree - high_times` times low, then high.
WeightedPoint blossom(const Spline& s, std::size_t span, double low, double high, std::size_t high_times) {
  WeightedPoint p[kMaxDegree + 1];
  const std::size_t d = std::size_t(s.degree);
  for (std::size_t k = 0; k <= d; ++k) {
    const std::size_t at = span - d + k;
    const double w = s.weights.empty() ? 1.0 : s.weights[at];
    p[k] = {w * s.control[at].x_mm, w * s.control[at].y_mm, w};
  }
  for (std::size_t level = 1; level <= d; ++level)
    for (std::size_t k = d; k >= level; --k) {
      const double u = level + high_times <= d ? low : high;
      const std::size_t at = span - d + k;
      const double left = s.knots[at], right = s.knots[at + 1 + d - level];
      const double a = right > left ? (u - left) / (right - left) : 0.0;
      p[k].x = (1.0 - a) * p[k - 1].x + a * p[k].x;
      p[k].y = (1.0 - a) * p[k - 1].y + a * p[k].y;
      p[k].w = (1.0 - a) * p[k - 1].w + a * p[k].w;
    }
  return p[d];
}

/// Adds the arc of a circle that a rational Bezier curve of the second degree is: its sides are equal, and
/// the middle weight is the cosine of half the arc's angle. False where it is none.
bool add_circle(std::span<const WeightedPoint> c, ShapedPoints& out) {
  constexpr double kSame = 1e-9;
  if (c.size() != 3) return false;
  const Point2 a = c[0].point(), b = c[1].point(), d = c[2].point();
  const Point2 middle{0.5 * (a.x_mm + d.x_mm), 0.5 * (a.y_mm + d.y_mm)};
  const double side = distance(a, b), height = distance(b, middle), half = distance(a, middle);
  const double weight = c[1].w / std::sqrt(c[0].w * c[2].w);
  if (!(height > kSame) || std::abs(side - distance(b, d)) > kSame || std::abs(weight - half / side) > kSame)
    return false;
  const double away = side * side / (height * height);
  const Point2 centre{b.x_mm + away * (middle.x_mm - b.x_mm), b.y_mm + away * (middle.y_mm - b.y_mm)};
  const double turn = (b.x_mm - a.x_mm) * (d.y_mm - b.y_mm) - (b.y_mm - a.y_mm) * (d.x_mm - b.x_mm);
  add_arc(out.points.back(), d, centre, turn > 0.0 ? 1.0 : -1.0, out);
  return true;
}

/// Points of a span that no few Bezier curves follow.
void sample_span(const Spline& s, std::size_t span, std::vector<Point2>& out) {
  constexpr int kLook = 8;  // chords of a first look at the span's length
  const double low = s.knots[span], high = s.knots[span + 1];
  const auto at = [&](double x) {
    const double u = low + x * (high - low);
    return blossom(s, span, u, u, 0).point();
  };
  Point2 before = at(0.0);
  double length = 0.0;
  for (int i = 1; i <= kLook; ++i) {
    const Point2 next = at(double(i) / kLook);
    length += distance(before, next);
    before = next;
  }
  const int n = shape_points(length / kSplineChord_mm);
  for (int i = 1; i <= n; ++i) add(at(double(i) / n), out);
}

void check_spline(const Spline& s) {
  check(s.degree >= 1 && s.degree <= kMaxDegree,
        fmt::format("a SPLINE of degree {}; it must lie in [1, {}]", s.degree, kMaxDegree));
  const std::size_t d = std::size_t(s.degree);
  check(!s.control.empty(), "a SPLINE without control points and without fit points");
  check(s.control.size() > d,
        fmt::format("a SPLINE of degree {} with {} control points", d, s.control.size()));
  check(s.knots.size() == s.control.size() + d + 1,
        fmt::format("a SPLINE with {} knots; {} control points of degree {} need {}", s.knots.size(),
                    s.control.size(), d, s.control.size() + d + 1));
  check(s.weights.empty() || s.weights.size() == s.control.size(),
        fmt::format("a SPLINE with {} weights and {} control points", s.weights.size(), s.control.size()));
  constexpr double kMax = 1e12;
  for (std::size_t i = 0; i < s.knots.size(); ++i)
    check(std::abs(s.knots[i]) <= kMax && (i == 0 || s.knots[i] >= s.knots[i - 1]),
          fmt::format("a SPLINE whose knot {} is {}: knots must ascend", i, s.knots[i]));
  for (const double w : s.weights)
    check(w > 1.0 / kMax && w < kMax, fmt::format("a SPLINE with a weight of {}; it must be above 0", w));
  for (const Point2& p : s.control)
    for (const double v : {p.x_mm, p.y_mm})
      check(std::abs(v) <= kMaxCoordinate_mm,
            fmt::format("{} mm is beyond the limit of +-{} mm", v, kMaxCoordinate_mm));
}

}  // namespace

void sample(std::span<const Vertex> polyline, bool closed, const PlaneTransform& to_mm, ShapedPoints& out) {
  check(!polyline.empty(), "a polyline without vertices");
  add(to_mm(polyline.front().at), out.points);
  for (std::size_t i = 0; i + 1 < polyline.size(); ++i)
    add_segment(polyline[i], polyline[i + 1].at, to_mm, out);
  if (closed && polyline.size() > 1) add_segment(polyline.back(), polyline.front().at, to_mm, out);
}

void sample(const Arc& given, const PlaneTransform& to_mm, ShapedPoints& out) {
  constexpr double kMax = 1e6;
  check(std::abs(given.from) <= kMax && std::abs(given.to) <= kMax,
        fmt::format("an arc from {} to {} rad", given.from, given.to));
  const Arc arc = transformed(given, to_mm);
  const double sweep = sweep_of(arc), radius = major_radius(arc);
  check(radius > 0.0 && radius <= kMaxCoordinate_mm,
        fmt::format("a radius of {} mm; it must lie in (0, {}]", radius, kMaxCoordinate_mm));
  const auto at = [&](double t) {
    const double x = std::cos(t), y = std::sin(t);
    return Point2{arc.centre.x_mm + x * arc.first.x_mm + y * arc.second.x_mm,
                  arc.centre.y_mm + x * arc.first.y_mm + y * arc.second.y_mm};
  };
  add(at(arc.from), out.points);
  const Point2 start = out.points.front();
  add_arc(arc, sweep, sweep == kTurn ? start : at(arc.from + sweep), out);
}

void sample(const Spline& s, ShapedPoints& out) {
  check_spline(s);
  constexpr double kSame_mm = 1e-9;
  const std::size_t d = std::size_t(s.degree);
  std::vector<WeightedPoint> control(d + 1);
  std::vector<CubicBezier> pieces;
  for (std::size_t span = d; span < s.control.size(); ++span) {
    const double low = s.knots[span], high = s.knots[span + 1];
    if (!(high > low)) continue;
    for (std::size_t k = 0; k <= d; ++k) control[k] = blossom(s, span, low, high, k);
    const Point2 start = control[0].point();
    if (out.points.empty() || distance(out.points.back(), start) > kSame_mm) add(start, out.points);
    pieces.clear();
    if (d == 1)
      add(control[1].point(), out.points);
    else if (add_circle(control, out))
      continue;
    else if (cubic_pieces(control, pieces))
      for (const CubicBezier& piece : pieces) add_bezier(piece, out);
    else
      sample_span(s, span, out.points);
  }
  check(!out.points.empty(), "a SPLINE whose knots are all the same");
}

void sample(std::span<const CubicBezier> curves, const PlaneTransform& to_mm, ShapedPoints& out) {
  for (const CubicBezier& curve : curves) {
    if (out.points.empty()) add(to_mm(curve[0]), out.points);
    add_bezier({out.points.back(), to_mm(curve[1]), to_mm(curve[2]), to_mm(curve[3])}, out);
  }
}

}  // namespace firn::dxf
