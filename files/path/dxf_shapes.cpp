#include "files/path/dxf_shapes.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>

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

/// De Boor's algorithm in homogeneous coordinates.
Point2 evaluate(const Spline& s, std::size_t span, double u) {
  double x[kMaxDegree + 1], y[kMaxDegree + 1], w[kMaxDegree + 1];
  const std::size_t d = std::size_t(s.degree);
  for (std::size_t k = 0; k <= d; ++k) {
    const std::size_t at = span - d + k;
    w[k] = s.weights.empty() ? 1.0 : s.weights[at];
    x[k] = w[k] * s.control[at].x_mm;
    y[k] = w[k] * s.control[at].y_mm;
  }
  for (std::size_t level = 1; level <= d; ++level)
    for (std::size_t k = d; k >= level; --k) {
      const std::size_t at = span - d + k;
      const double left = s.knots[at], right = s.knots[at + 1 + d - level];
      const double a = right > left ? (u - left) / (right - left) : 0.0;
      x[k] = (1.0 - a) * x[k - 1] + a * x[k];
      y[k] = (1.0 - a) * y[k - 1] + a * y[k];
      w[k] = (1.0 - a) * w[k - 1] + a * w[k];
    }
  return {x[d] / w[d], y[d] / w[d]};
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
                    std::vector<Point2>& out) {
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
  const int n = shape_points(turn * radius / kSplineChord_mm);
  for (int i = 0; i <= n; ++i) {
    if (whole && i == n) return add(out.front(), out);
    const double t = from + turn * double(i) / n, u = std::cos(t), v = side * std::sin(t);
    add({centre.x_mm + u * major.x_mm - v * major.y_mm, centre.y_mm + u * major.y_mm + v * major.x_mm}, out);
  }
}

void sample(const Spline& s, std::vector<Point2>& out) {
  check_spline(s);
  constexpr int kLook = 8;  // chords of a first look at a span's length
  const std::size_t d = std::size_t(s.degree);
  for (std::size_t span = d; span < s.control.size(); ++span) {
    const double low = s.knots[span], high = s.knots[span + 1];
    if (!(high > low)) continue;
    const auto at = [&](double x) { return evaluate(s, span, low + x * (high - low)); };
    Point2 before = at(0.0);
    if (out.empty()) add(before, out);
    double length = 0.0;
    for (int i = 1; i <= kLook; ++i) {
      const Point2 next = at(double(i) / kLook);
      length += distance(before, next);
      before = next;
    }
    const int n = s.degree == 1 ? 1 : shape_points(length / kSplineChord_mm);
    for (int i = 1; i <= n; ++i) add(at(double(i) / n), out);
  }
  check(!out.empty(), "a SPLINE whose knots are all the same");
}

}  // namespace firn::dxf
