#include "files/path/fit_spline.h"

#include <cmath>
#include <cstddef>

namespace firn {
namespace {

Point2 operator+(Point2 a, Point2 b) { return {a.x_mm + b.x_mm, a.y_mm + b.y_mm}; }
Point2 operator-(Point2 a, Point2 b) { return {a.x_mm - b.x_mm, a.y_mm - b.y_mm}; }
Point2 operator*(double k, Point2 a) { return {k * a.x_mm, k * a.y_mm}; }

/// A row of the equations for the derivatives: low m[i-1] + middle m[i] + high m[i+1] = right.
struct SplineRow {
  double low = 0.0, middle = 1.0, high = 0.0;
  Point2 right;
};

/// Solves the tridiagonal equations by elimination [Thomas]; low of the first and high of the last row are
/// unused.
std::vector<Point2> solve_spline(std::vector<SplineRow> rows) {
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const double share = rows[i].low / rows[i - 1].middle;
    rows[i].middle -= share * rows[i - 1].high;
    rows[i].right = rows[i].right - share * rows[i - 1].right;
  }
  std::vector<Point2> m(rows.size());
  for (std::size_t i = rows.size(); i-- > 0;) {
    const Point2 known = i + 1 < rows.size() ? rows[i].right - rows[i].high * m[i + 1] : rows[i].right;
    m[i] = (1.0 / rows[i].middle) * known;
  }
  return m;
}

/// Solves equations whose first and last unknowns are neighbours, too [Sherman, Morrison].
std::vector<Point2> solve_spline_cycle(std::vector<SplineRow> rows) {
  const std::size_t last = rows.size() - 1;
  const double corner_low = rows[0].low, corner_high = rows[last].high, gamma = -rows[0].middle;
  rows[0].middle -= gamma;
  rows[last].middle -= corner_low * corner_high / gamma;
  std::vector<SplineRow> column = rows;
  for (SplineRow& row : column) row.right = {};
  column[0].right = {gamma, gamma};
  column[last].right = {corner_high, corner_high};
  const std::vector<Point2> m = solve_spline(std::move(rows)), z = solve_spline(std::move(column));
  const double ratio = corner_low / gamma, below = 1.0 + z[0].x_mm + ratio * z[last].x_mm;
  const Point2 share = (1.0 / below) * (m[0] + ratio * m[last]);
  std::vector<Point2> out(m.size());
  for (std::size_t i = 0; i < m.size(); ++i) out[i] = m[i] - z[i].x_mm * share;
  return out;
}

SplineRow inner_row(Point2 before, Point2 at, Point2 after, double h_before, double h_after) {
  return {h_after, 2.0 * (h_before + h_after), h_before,
          3.0 * ((h_after / h_before) * (at - before) + (h_before / h_after) * (after - at))};
}

/// The row of an end: the unit tangent, or a second derivative of 0.
SplineRow end_row(const std::optional<Point2>& tangent, Point2 from, Point2 to, double h) {
  const double length = tangent ? distance({}, *tangent) : 0.0;
  if (length > 0.0) return {0.0, 1.0, 0.0, (1.0 / length) * *tangent};
  return {1.0, 2.0, 1.0, (3.0 / h) * (to - from)};
}

}  // namespace

std::vector<CubicBezier> fit_spline(std::span<const Point2> given, bool closed, const EndTangents& tangents) {
  std::vector<Point2> p;
  for (const Point2& q : given)
    if (p.empty() || q != p.back()) p.push_back(q);
  if (closed && p.size() > 1 && p.front() == p.back()) p.pop_back();
  if (p.size() < 2) return {};
  closed = closed && p.size() > 2;
  if (closed) p.push_back(p.front());
  const std::size_t n = p.size() - 1;
  std::vector<double> h(n);
  for (std::size_t i = 0; i < n; ++i) h[i] = distance(p[i], p[i + 1]);
  std::vector<SplineRow> rows;
  rows.push_back(closed ? inner_row(p[n - 1], p[0], p[1], h[n - 1], h[0])
                        : end_row(tangents.start, p[0], p[1], h[0]));
  for (std::size_t i = 1; i < n; ++i) rows.push_back(inner_row(p[i - 1], p[i], p[i + 1], h[i - 1], h[i]));
  if (!closed) rows.push_back(end_row(tangents.end, p[n - 1], p[n], h[n - 1]));
  std::vector<Point2> m = closed ? solve_spline_cycle(std::move(rows)) : solve_spline(std::move(rows));
  if (closed) m.push_back(m.front());
  std::vector<CubicBezier> pieces(n);
  for (std::size_t i = 0; i < n; ++i)
    pieces[i] = {p[i], p[i] + (h[i] / 3.0) * m[i], p[i + 1] - (h[i] / 3.0) * m[i + 1], p[i + 1]};
  return pieces;
}

}  // namespace firn
