#include "core/motion/curve/frechet.h"

#include <algorithm>
#include <cmath>

namespace firn::motion {
namespace {

constexpr double kSharp = 1.01, kSharpMm = 1e-6;
constexpr int kDivisions = 12;
constexpr int kNewton = 4;

double square(Point2 p) { return p.x_mm * p.x_mm + p.y_mm * p.y_mm; }
Point2 middle(Point2 a, Point2 b) { return {0.5 * (a.x_mm + b.x_mm), 0.5 * (a.y_mm + b.y_mm)}; }

struct Jet {
  Point2 at, d1, d2;
};

Jet jet(const Curve& c, std::size_t i, double s) {
  const double h = c.s[i + 1] - c.s[i], over = 1.0 / h, u = s - c.s[i], w = h - u;
  const auto axis = [&](const std::vector<double>& f, const std::vector<double>& m, double& p, double& d1,
                        double& d2) {
    const double left = m[i] * over, right = m[i + 1] * over;
    p = (w * f[i] + u * f[i + 1]) * over + (left * w * (w * w - h * h) + right * u * (u * u - h * h)) / 6.0;
    d1 = (f[i + 1] - f[i]) * over + (left * (h * h - 3.0 * w * w) + right * (3.0 * u * u - h * h)) / 6.0;
    d2 = left * w + right * u;
  };
  Jet j;
  axis(c.x, c.xx, j.at.x_mm, j.d1.x_mm, j.d2.x_mm);
  axis(c.y, c.yy, j.at.y_mm, j.d1.y_mm, j.d2.y_mm);
  return j;
}

/// Walks along the curve to the place nearest to each vertex, never back.
class Walk {
 public:
  explicit Walk(const Curve& curve) : curve_(curve) {}

  /// The parameter of a place near p, from the present one on and at most about twice `ahead_mm` further.
  double to(Point2 p, double ahead_mm) {
    const double from = s_, least_speed = 1e-3;
    const double ahead = ahead_mm / std::max(least_speed, std::sqrt(square(jet(curve_, cell_, from).d1)));
    const double most = std::min(curve_.s.back(), from + 2.0 * ahead);
    double s = std::min(from + ahead, most);
    for (int step = 0; step < kNewton; ++step) {
      seek(s);
      const Jet j = jet(curve_, cell_, s);
      const double dx = j.at.x_mm - p.x_mm, dy = j.at.y_mm - p.y_mm;
      const double along = dx * j.d1.x_mm + dy * j.d1.y_mm, speed = square(j.d1);
      const double bend = speed + dx * j.d2.x_mm + dy * j.d2.y_mm;
      const double slope = std::max(bend, 0.25 * speed);
      if (!(slope > 0.0)) break;
      const double next = std::clamp(s - along / slope, from, most);
      if (std::abs(next - s) < 1e-3 * ahead) {
        s = next;
        break;
      }
      s = next;
    }
    seek(s);
    return s_ = s;
  }

 private:
  void seek(double s) {
    while (cell_ > 0 && s < curve_.s[cell_]) --cell_;
    while (cell_ + 1 < curve_.cells() && s >= curve_.s[cell_ + 1]) ++cell_;
  }
  const Curve& curve_;
  double s_ = 0.0;
  std::size_t cell_ = 0;
};

/// Raises `worst` (squared) to a bound of the cubic with these Bezier points. The ends are places of it.
void raise(Point2 a, Point2 b, Point2 c, Point2 d, int divisions, double& worst) {
  worst = std::max({worst, square(a), square(d)});
  const double hull = std::max(square(b), square(c));
  const double sharp = std::sqrt(worst) * kSharp + kSharpMm;
  if (hull <= sharp * sharp) {
    worst = std::max(worst, hull);
    return;
  }
  if (divisions == 0) {
    worst = hull;
    return;
  }
  const Point2 ab = middle(a, b), bc = middle(b, c), cd = middle(c, d), abc = middle(ab, bc),
               bcd = middle(bc, cd), m = middle(abc, bcd);
  raise(a, ab, abc, m, divisions - 1, worst);
  raise(m, bcd, cd, d, divisions - 1, worst);
}

/// A straight curve: the walk stays where it is while the polygon turns back.
double straight_bound(std::span<const Point2> points) {
  const Point2 a = points.front(), b = points.back();
  const double length = distance(a, b), tx = (b.x_mm - a.x_mm) / length, ty = (b.y_mm - a.y_mm) / length;
  double worst = 0.0, at = 0.0;
  for (const Point2& p : points) {
    const double x = p.x_mm - a.x_mm, y = p.y_mm - a.y_mm, along = x * tx + y * ty, aside = x * ty - y * tx;
    at = std::min(std::max(at, along), length);
    worst = std::max(worst, aside * aside + (along - at) * (along - at));
  }
  return std::sqrt(worst);
}

}  // namespace

double frechet_bound(const Curve& curve, std::span<const Point2> points, std::vector<double>& parameter) {
  if (curve.straight) return straight_bound(points);
  const std::size_t n = points.size();
  parameter.resize(n);
  parameter[0] = 0.0;
  Walk walk(curve);
  for (std::size_t i = 1; i + 1 < n; ++i)
    parameter[i] = walk.to(points[i], distance(points[i - 1], points[i]));
  parameter[n - 1] = curve.s.back();
  double worst = 0.0;
  std::size_t cell = 0;
  Jet left = jet(curve, 0, 0.0);  // the curve is C2: at a knot either cell's will do
  double left_s = 0.0;
  for (std::size_t i = 0; i + 1 < n; ++i) {
    const double from = parameter[i], to = parameter[i + 1];
    const Point2 &p = points[i], &q = points[i + 1];
    const auto polygon = [&](double s) {
      const double x = to > from ? (s - from) / (to - from) : 1.0;
      return Point2{p.x_mm + x * (q.x_mm - p.x_mm), p.y_mm + x * (q.y_mm - p.y_mm)};
    };
    double s = from;
    while (cell > 0 && s < curve.s[cell]) --cell;
    do {
      while (cell + 1 < curve.cells() && s >= curve.s[cell + 1]) ++cell;
      const double end = std::min(to, cell + 1 < curve.cells() ? curve.s[cell + 1] : to),
                   third = (end - s) / 3.0;
      if (s != left_s) left = jet(curve, cell, s);
      const Jet right = jet(curve, cell, end);
      const Point2 p0 = s == from ? p : polygon(s), p3 = end == to ? q : polygon(end);
      const double px = (p3.x_mm - p0.x_mm) / 3.0, py = (p3.y_mm - p0.y_mm) / 3.0;
      const Point2 a{left.at.x_mm - p0.x_mm, left.at.y_mm - p0.y_mm},
          d{right.at.x_mm - p3.x_mm, right.at.y_mm - p3.y_mm};
      raise(a, {a.x_mm + third * left.d1.x_mm - px, a.y_mm + third * left.d1.y_mm - py},
            {d.x_mm - third * right.d1.x_mm + px, d.y_mm - third * right.d1.y_mm + py}, d, kDivisions, worst);
      s = left_s = end;
      left = right;
    } while (s < to);
  }
  return std::sqrt(worst);
}

}  // namespace firn::motion
