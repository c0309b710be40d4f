#include "core/motion/curve/frechet.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/motion/curve/constants.h"
#include "core/motion/curve/in_order.h"

namespace firn::motion {
namespace {

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
  /// @param precise places are the nearest ones to the last digits
  explicit Walk(const Curve& curve, bool precise = false)
      : curve_(curve), jet_(jet(curve, 0, 0.0)), precise_(precise) {}

  double s() const { return s_; }
  std::size_t cell() const { return cell_; }
  const Jet& here() const { return jet_; }

  /// To a place near p, from `back_mm` before the present one on and at most about twice `ahead_mm` further.
  void to(Point2 p, double ahead_mm, double back_mm = 0.0) {
    const int steps = precise_ ? kPreciseNewtonSteps : kNewtonSteps;
    const double from = s_, rate = std::max(kMinParameterSpeed, std::sqrt(square(jet_.d1)));
    const double ahead = ahead_mm / rate, least = std::max(0.0, from - back_mm / rate);
    const double most = std::min(curve_.s.back(), from + 2.0 * ahead);
    const double close = (precise_ ? kPreciseNearestChange : kNearestChange) * ahead;
    double s = std::min(from + stretch_ * ahead, most);
    bool near = false;
    for (int step = 0; step < steps && !near; ++step) {
      seek(s);
      jet_ = jet(curve_, cell_, s);
      const double dx = jet_.at.x_mm - p.x_mm, dy = jet_.at.y_mm - p.y_mm;
      const double along = dx * jet_.d1.x_mm + dy * jet_.d1.y_mm, speed = square(jet_.d1);
      const double bend = speed + dx * jet_.d2.x_mm + dy * jet_.d2.y_mm;
      const double slope = std::max(bend, 0.25 * speed);
      const double next = slope > 0.0 ? std::clamp(s - along / slope, least, most) : s;
      near = std::abs(next - s) < close || next == s;
      if (!near) s = next;
    }
    if (!near) {
      seek(s);
      jet_ = jet(curve_, cell_, s);
    }
    stretch_ = ahead > 0.0 ? std::clamp((s - from) / ahead, 1.0, kMaxStretchGuess) : 1.0;  // of arc and chord
    s_ = s;
  }

  void to_end() {
    s_ = curve_.s.back();
    cell_ = curve_.cells() - 1;
    jet_ = jet(curve_, cell_, s_);
  }

 private:
  void seek(double s) {
    while (cell_ > 0 && s < curve_.s[cell_]) --cell_;
    while (cell_ + 1 < curve_.cells() && s >= curve_.s[cell_ + 1]) ++cell_;
  }
  const Curve& curve_;
  Jet jet_;
  bool precise_;
  double s_ = 0.0, stretch_ = 1.0;
  std::size_t cell_ = 0;
};

void halve(Point2 a, Point2 b, Point2 c, Point2 d, double hull, int divisions, double& worst);

/// Raises `worst` (squared) to a bound of the cubic with these Bezier points. The ends are places of it.
inline void raise(Point2 a, Point2 b, Point2 c, Point2 d, int divisions, double& worst) {
  const double ends = std::max(square(a), square(d)), hull = std::max(square(b), square(c));
  worst = std::max(worst, ends);
  if (hull > worst) halve(a, b, c, d, hull, divisions, worst);
}

/// Sharper than their hull (squared): the parabola through both ends and the middle m, whose two halves have
/// the Bezier points a, m + (a - d) / 4, m, m - (a - d) / 4, d, is off by at most |third difference| / (12
/// sqrt 3).
void halve(Point2 a, Point2 b, Point2 c, Point2 d, double hull, int divisions, double& worst) {
  const Point2 ab = middle(a, b), bc = middle(b, c), cd = middle(c, d), abc = middle(ab, bc),
               bcd = middle(bc, cd), m = middle(abc, bcd);
  worst = std::max(worst, square(m));
  const double sharp = std::sqrt(worst) * kDeviationSharpness + kDeviationSharpness_mm;
  const Point2 quarter{0.25 * (a.x_mm - d.x_mm), 0.25 * (a.y_mm - d.y_mm)},
      third{d.x_mm - a.x_mm + 3.0 * (b.x_mm - c.x_mm), d.y_mm - a.y_mm + 3.0 * (b.y_mm - c.y_mm)};
  const double bend = std::max(square({m.x_mm + quarter.x_mm, m.y_mm + quarter.y_mm}),
                               square({m.x_mm - quarter.x_mm, m.y_mm - quarter.y_mm}));
  const double bound = std::min(
      std::sqrt(hull), std::sqrt(std::max(bend, worst)) + kCubicOverParabola * std::sqrt(square(third)));
  if (bound <= sharp || divisions == 0) {
    worst = std::max(worst, bound * bound);
    return;
  }
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

/// Curve minus polygon over a part of a cell.
struct Piece {
  double from, to;  ///< parameters of the curve
  Point2 at[4];     ///< Bezier points
};

/// Calls visit(Piece) along the correspondence of the polygon's places with those of the curve.
template <class Visit>
void follow(const Curve& curve, std::span<const Point2> points, Visit visit) {
  const std::size_t n = points.size();
  Walk walk(curve);
  for (std::size_t i = 0; i + 1 < n; ++i) {
    const Point2 &p = points[i], &q = points[i + 1];
    const double from = walk.s();
    std::size_t cell = walk.cell();
    Jet left = walk.here();
    if (i + 2 < n)
      walk.to(q, distance(p, q));
    else
      walk.to_end();
    const double to = walk.s(), over = to > from ? 1.0 / (to - from) : 0.0;
    double s = from;
    Point2 p0 = p;
    for (bool last = false; !last;) {
      while (cell + 1 < curve.cells() && s >= curve.s[cell + 1]) ++cell;
      last = cell + 1 >= curve.cells() || curve.s[cell + 1] >= to;
      const double end = last ? to : curve.s[cell + 1], third = (end - s) / 3.0, x = (end - from) * over;
      const Jet right = last ? walk.here() : jet(curve, cell, end);  // the curve is C2: either cell's will do
      const Point2 p3 = last ? q : Point2{p.x_mm + x * (q.x_mm - p.x_mm), p.y_mm + x * (q.y_mm - p.y_mm)};
      const double px = (p3.x_mm - p0.x_mm) / 3.0, py = (p3.y_mm - p0.y_mm) / 3.0;
      const Point2 a{left.at.x_mm - p0.x_mm, left.at.y_mm - p0.y_mm},
          d{right.at.x_mm - p3.x_mm, right.at.y_mm - p3.y_mm};
      visit(Piece{s,
                  end,
                  {a,
                   {a.x_mm + third * left.d1.x_mm - px, a.y_mm + third * left.d1.y_mm - py},
                   {d.x_mm - third * right.d1.x_mm + px, d.y_mm - third * right.d1.y_mm + py},
                   d}});
      s = end;
      left = right;
      p0 = p3;
    }
  }
}

}  // namespace

double frechet_bound(const Curve& curve, std::span<const Point2> points) {
  if (!(curve.s.back() > 0.0)) return std::numeric_limits<double>::infinity();
  if (curve.straight) return straight_bound(points);
  double worst = 0.0;
  follow(curve, points,
         [&](const Piece& p) { raise(p.at[0], p.at[1], p.at[2], p.at[3], kMaxDivisions, worst); });
  return std::sqrt(worst);
}

void find_stretches_beyond(const Curve& curve, std::span<const Point2> points, double limit_mm,
                           std::vector<StretchBeyond>& found) {
  found.clear();
  if (!(curve.s.back() > 0.0) || curve.straight) return;
  const double limit = limit_mm * limit_mm;
  follow(curve, points, [&](const Piece& p) {
    double worst = limit;
    raise(p.at[0], p.at[1], p.at[2], p.at[3], kMaxDivisions, worst);
    if (worst > limit) found.push_back({p.from, p.to, std::sqrt(worst) - limit_mm});
  });
}

double farthest_point_mm(const Curve& curve, std::span<const Point2> points, double within_mm) {
  if (!(curve.s.back() > 0.0)) return std::numeric_limits<double>::infinity();
  if (curve.straight) return straight_bound(points);
  std::vector<double> at;
  Walk walk(curve, true);
  for (std::size_t i = 1; i + 1 < points.size(); ++i) {
    walk.to(points[i], distance(points[i - 1], points[i]), 2.0 * within_mm);
    at.push_back(walk.s());
  }
  put_in_order(at);
  double most = 0.0;
  std::size_t cell = 0;
  for (std::size_t i = 0; i < at.size(); ++i) {
    while (cell + 1 < curve.cells() && at[i] >= curve.s[cell + 1]) ++cell;
    const double off = distance(jet(curve, cell, at[i]).at, points[i + 1]);
    if (!std::isfinite(off)) return std::numeric_limits<double>::infinity();
    most = std::max(most, off);
  }
  return most;
}

}  // namespace firn::motion
