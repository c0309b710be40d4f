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

void add_segment(Point2 a, Point2 b, double bulge, ShapedPoints& out) {
  constexpr double kLeastSagitta_mm = 1e-7;
  const double chord = distance(a, b);
  check(std::isfinite(bulge) && std::isfinite(chord), "a polyline with a number that is not finite");
  if (0.5 * std::abs(bulge) * chord < kLeastSagitta_mm) return add(b, out.points);
  const double away = 0.25 * (1.0 - bulge * bulge) / bulge;  // from the chord's middle, in chords
  const Point2 centre{0.5 * (a.x_mm + b.x_mm) - away * (b.y_mm - a.y_mm),
                      0.5 * (a.y_mm + b.y_mm) + away * (b.x_mm - a.x_mm)};
  add_arc(a, b, centre, bulge > 0.0 ? 1.0 : -1.0, out);
}

void add_bezier(const CubicBezier& c, ShapedPoints& out) {
  const std::size_t first = out.points.size() - 1;
  const int samples = sample_bezier(c[0], c[1], c[2], c[3], [&](Point2 p) { add(p, out.points); });
  give_bezier(c[0], c[1], c[2], c[3], samples, first, out.points.size() - 1, out.given);
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
  check(!s.control.empty(), "a SPLINE without control points is not read: convert it");
  check(s.control.size() > d,
        fmt::format("a SPLINE of degree {} with {} control points", d, s.control.size()));
  check(s.knots.size() == s.control.size() + d + 1,
        fmt::format("a SPLINE with {} knots; {} control points of degree {} need {}", s.knots.size(),
                    s.control.size(), d, s.control.size() + d + 1));
  check(s.weights.empty() || s.weights.size() == s.control.size(),
        fmt::format("a SPLINE with {} weights and {} control points", s.weights.size(), s.control.size()));
  constexpr double kMost = 1e12;
  for (std::size_t i = 0; i < s.knots.size(); ++i)
    check(std::abs(s.knots[i]) <= kMost && (i == 0 || s.knots[i] >= s.knots[i - 1]),
          fmt::format("a SPLINE whose knot {} is {}: knots must ascend", i, s.knots[i]));
  for (const double w : s.weights)
    check(w > 1.0 / kMost && w < kMost, fmt::format("a SPLINE with a weight of {}; it must be above 0", w));
  for (const Point2& p : s.control)
    for (const double v : {p.x_mm, p.y_mm})
      check(std::abs(v) <= kMaxCoordinate_mm,
            fmt::format("{} mm is beyond the limit of +-{} mm", v, kMaxCoordinate_mm));
}

}  // namespace

void sample(std::span<const Vertex> polyline, bool closed, ShapedPoints& out) {
  check(!polyline.empty(), "a polyline without vertices");
  add(polyline.front().at, out.points);
  for (std::size_t i = 0; i + 1 < polyline.size(); ++i)
    add_segment(polyline[i].at, polyline[i + 1].at, polyline[i].bulge, out);
  if (closed && polyline.size() > 1)
    add_segment(polyline.back().at, polyline.front().at, polyline.back().bulge, out);
}

void sample_arc(Point2 centre, double radius_mm, double from_deg, double to_deg, ShapedPoints& out) {
  check(radius_mm > 0.0 && radius_mm <= kMaxCoordinate_mm,
        fmt::format("a radius of {} mm; it must lie in (0, {}]", radius_mm, kMaxCoordinate_mm));
  constexpr double kMost_deg = 1e6;
  check(std::abs(from_deg) <= kMost_deg && std::abs(to_deg) <= kMost_deg,
        fmt::format("angles from {} to {} degrees", from_deg, to_deg));
  const auto at = [&](double degrees) {
    const double angle = degrees * std::numbers::pi / 180.0;
    return Point2{centre.x_mm + radius_mm * std::cos(angle), centre.y_mm + radius_mm * std::sin(angle)};
  };
  const bool whole = std::fmod(to_deg - from_deg, 360.0) == 0.0;
  const Point2 start = at(from_deg);
  add(start, out.points);
  add_arc(start, whole ? start : at(to_deg), centre, 1.0, out);
}

void sample_ellipse(Point2 centre, Point2 major, double ratio, double from, double to, bool mirrored,
                    ShapedPoints& out) {
  const double radius = distance({}, major);
  check(radius > 0.0 && radius <= kMaxCoordinate_mm,
        fmt::format("a major axis of {} mm; it must lie in (0, {}]", radius, kMaxCoordinate_mm));
  check(ratio > 0.0 && ratio <= 1.0, fmt::format("a ratio of axes of {}; it must lie in (0, 1]", ratio));
  constexpr double kMost = 1e6;
  check(std::abs(from) <= kMost && std::abs(to) <= kMost, fmt::format("parameters {} to {}", from, to));
  double turn = std::fmod(to - from, kTurn);
  if (turn <= 0.0) turn += kTurn;
  constexpr double kWhole = 1e-9;
  const bool whole = turn > kTurn - kWhole;
  const double side = mirrored ? -ratio : ratio;
  const auto place = [&](double u, double v) {
    return Point2{centre.x_mm + u * major.x_mm - side * v * major.y_mm,
                  centre.y_mm + u * major.y_mm + side * v * major.x_mm};
  };
  const auto at = [&](double t) { return place(std::cos(t), std::sin(t)); };
  add(at(from), out.points);
  const Point2 start = out.points.front(), end = whole ? start : at(from + turn);
  if (ratio == 1.0) return add_arc(start, end, centre, mirrored ? -1.0 : 1.0, out);
  const int n = std::max(1, int(std::ceil(turn / kTurn * ellipse_pieces(radius))));
  const double step = turn / n, handle = 4.0 / 3.0 * std::tan(0.25 * step);
  for (int i = 0; i < n; ++i) {
    const double a = from + i * step, b = a + step;
    add_bezier(
        {out.points.back(), place(std::cos(a) - handle * std::sin(a), std::sin(a) + handle * std::cos(a)),
         place(std::cos(b) + handle * std::sin(b), std::sin(b) - handle * std::cos(b)),
         i + 1 < n ? at(b) : end},
        out);
  }
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

}  // namespace firn::dxf
