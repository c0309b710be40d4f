// Computes curves that nobody tuned a planner for, drawn from a seed, and their samples as users have them:
// at any spacing, rounded to decimals.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "core/grid/random.h"
#include "core/path/path.h"

namespace firn::motion {

inline constexpr int kCurveKinds = 6;
inline const char* const kCurveKind[kCurveKinds] = {"lobes",   "splines", "ellipses",
                                                    "spirals", "offsets", "fillets"};

/// A curve by its parameter in [0, 1], about the origin, at most some 120 mm across.
using ParametricCurve = std::function<Point2(double)>;

namespace curves {

inline ParametricCurve lobes(RandomStream& draw) {
  const double radius = draw.uniform(8.0, 35.0);
  const int lobes = 3 + int(draw.below(6));
  const double depth = radius * draw.uniform(0.05, 0.35), phase = draw.uniform(0.0, 6.28);
  const double second = 0.3 * depth * draw.uniform(0.0, 1.0);
  return [=](double t) {
    const double a = 2.0 * std::numbers::pi * t;
    const double r = radius + depth * std::cos(lobes * a) + second * std::cos((lobes + 2) * a + phase);
    return Point2{r * std::cos(a), r * std::sin(a)};
  };
}

/// A uniform cubic B-spline through a random walk of control points.
inline ParametricCurve spline(RandomStream& draw) {
  std::vector<Point2> control{{-40.0, 0.0}};
  double heading = draw.uniform(-0.5, 0.5);
  const int n = 8 + int(draw.below(8));
  for (int i = 0; i < n; ++i) {
    const double length = draw.uniform(5.0, 12.0);
    const Point2 p = control.back();
    control.push_back({p.x_mm + length * std::cos(heading), p.y_mm + length * std::sin(heading)});
    heading += draw.uniform(-1.2, 1.2);
  }
  return [control](double t) {
    const double cells = double(control.size() - 3);
    const std::size_t k = std::min(std::size_t(t * cells), control.size() - 4);
    const double x = t * cells - double(k), y = 1.0 - x;
    const double w[4] = {y * y * y / 6.0, (3.0 * x * x * x - 6.0 * x * x + 4.0) / 6.0,
                         (3.0 * y * y * y - 6.0 * y * y + 4.0) / 6.0, x * x * x / 6.0};
    Point2 p;
    for (std::size_t i = 0; i < 4; ++i) {
      p.x_mm += w[i] * control[k + i].x_mm;
      p.y_mm += w[i] * control[k + i].y_mm;
    }
    return p;
  };
}

inline ParametricCurve ellipse(RandomStream& draw) {
  const double a = draw.uniform(10.0, 50.0), b = a * draw.uniform(0.25, 1.0);
  return [=](double t) {
    const double w = 2.0 * std::numbers::pi * t;
    return Point2{a * std::cos(w), b * std::sin(w)};
  };
}

inline ParametricCurve spiral(RandomStream& draw) {
  const double first = draw.uniform(1.0, 5.0), pitch = draw.uniform(2.0, 8.0), turns = draw.uniform(1.5, 4.0);
  return [=](double t) {
    const double w = 2.0 * std::numbers::pi * turns * t, r = first + pitch * turns * t;
    return Point2{r * std::cos(w), r * std::sin(w)};
  };
}

/// Polygons with rounded corners: closed outlines moved outwards (offsets), zig-zags (fillets).
inline ParametricCurve rounded(std::vector<Point2> corner, double radius) {
  struct Piece {
    Point2 from, to, centre;
    double start = 0.0, turn = 0.0, length = 0.0;
  };
  std::vector<Piece> pieces;
  Point2 at = corner.front();
  double total = 0.0;
  const auto add = [&](Piece p) {
    total += p.length;
    pieces.push_back(p);
  };
  for (std::size_t i = 1; i + 1 < corner.size(); ++i) {
    const Point2 a = corner[i - 1], b = corner[i], c = corner[i + 1];
    const double u = distance(a, b), v = distance(b, c);
    const double ux = (b.x_mm - a.x_mm) / u, uy = (b.y_mm - a.y_mm) / u, vx = (c.x_mm - b.x_mm) / v,
                 vy = (c.y_mm - b.y_mm) / v;
    const double turn = std::atan2(ux * vy - uy * vx, ux * vx + uy * vy);
    const double cut = std::min({radius * std::tan(0.5 * std::abs(turn)), 0.45 * u, 0.45 * v});
    if (std::abs(turn) < 1e-3) continue;
    const double r = cut / std::tan(0.5 * std::abs(turn)), side = turn > 0.0 ? 1.0 : -1.0;
    const Point2 in{b.x_mm - cut * ux, b.y_mm - cut * uy};
    add({at, in, {}, 0.0, 0.0, distance(at, in)});
    Piece arc;
    arc.centre = {in.x_mm - side * r * uy, in.y_mm + side * r * ux};
    arc.start = std::atan2(in.y_mm - arc.centre.y_mm, in.x_mm - arc.centre.x_mm);
    arc.turn = turn;
    arc.from = {r, 0.0};
    arc.length = r * std::abs(turn);
    add(arc);
    at = {b.x_mm + cut * vx, b.y_mm + cut * vy};
  }
  add({at, corner.back(), {}, 0.0, 0.0, distance(at, corner.back())});
  return [pieces, total](double t) {
    double s = t * total;
    for (const Piece& p : pieces) {
      if (s > p.length && &p != &pieces.back()) {
        s -= p.length;
        continue;
      }
      const double x = p.length > 0.0 ? std::min(1.0, s / p.length) : 0.0;
      if (p.turn == 0.0)
        return Point2{p.from.x_mm + x * (p.to.x_mm - p.from.x_mm),
                      p.from.y_mm + x * (p.to.y_mm - p.from.y_mm)};
      const double angle = p.start + x * p.turn;
      return Point2{p.centre.x_mm + p.from.x_mm * std::cos(angle),
                    p.centre.y_mm + p.from.x_mm * std::sin(angle)};
    }
    return pieces.back().to;
  };
}

inline ParametricCurve offset(RandomStream& draw) {
  std::vector<Point2> corner;
  const int n = 5 + int(draw.below(6));
  for (int i = 0; i < n; ++i) {
    const double a = 2.0 * std::numbers::pi * (i + draw.uniform(-0.3, 0.3)) / n, r = draw.uniform(12.0, 45.0);
    corner.push_back({r * std::cos(a), r * std::sin(a)});
  }
  const Point2 start{0.5 * (corner.front().x_mm + corner.back().x_mm),
                     0.5 * (corner.front().y_mm + corner.back().y_mm)};
  corner.insert(corner.begin(), start);
  corner.push_back(start);
  return rounded(corner, draw.uniform(0.5, 6.0));
}

inline ParametricCurve fillet(RandomStream& draw) {
  std::vector<Point2> corner;
  const double width = draw.uniform(10.0, 60.0), pitch = draw.uniform(0.8, 6.0);
  const int lines = 4 + int(draw.below(8));
  for (int i = 0; i < lines; ++i) {
    const double y = pitch * i - 0.5 * pitch * lines;
    corner.push_back({(i % 2 ? 0.5 : -0.5) * width, y});
    corner.push_back({(i % 2 ? -0.5 : 0.5) * width, y});
  }
  return rounded(corner, pitch * draw.uniform(0.15, 0.45));
}

/// 2 to 8 cusps, between arches.
inline ParametricCurve epicycloid(RandomStream& draw) {
  const double cusps = 2.0 + double(draw.below(7)), radius = draw.uniform(1.0, 5.0),
               heading = draw.uniform(0.0, 6.28);
  return [=](double t) {
    const double w = 2.0 * std::numbers::pi * t, other = (cusps + 1.0) * w + heading;
    return Point2{radius * ((cusps + 1.0) * std::cos(w + heading) - std::cos(other)),
                  radius * ((cusps + 1.0) * std::sin(w + heading) - std::sin(other))};
  };
}

}  // namespace curves

inline ParametricCurve random_curve(int kind, std::uint64_t seed) {
  RandomStream draw(seed * 8 + std::uint64_t(kind), Purpose::kTest);
  ParametricCurve (*const make[kCurveKinds])(RandomStream&) = {
      curves::lobes, curves::spline, curves::ellipse, curves::spiral, curves::offset, curves::fillet};
  return make[kind](draw);
}

inline Point2 rounded_to(Point2 p, int decimals) {
  const double scale = std::pow(10.0, decimals);
  return {std::round(p.x_mm * scale) / scale, std::round(p.y_mm * scale) / scale};
}

/// `chords` + 1 samples at equal parameters, rounded to decimals.
inline std::vector<Point2> at_parameters(const ParametricCurve& curve, int chords, int decimals) {
  std::vector<Point2> points;
  for (int i = 0; i <= chords; ++i) points.push_back(rounded_to(curve(double(i) / chords), decimals));
  return points;
}

/// Samples as far apart as their chords stay within `sagitta_mm` of the curve, rounded to decimals.
inline std::vector<Point2> within_sagitta(const ParametricCurve& curve, double sagitta_mm, int decimals) {
  constexpr int kFine = 20000, kChecked = 8;
  const auto at = [&](int i) { return curve(double(i) / kFine); };
  const auto stays = [&](int from, int to) {
    const Point2 a = at(from), b = at(to);
    const double x = b.x_mm - a.x_mm, y = b.y_mm - a.y_mm, length = std::sqrt(x * x + y * y);
    for (int k = 1; k < kChecked; ++k) {
      const Point2 p = at(from + (to - from) * k / kChecked);
      if (std::abs((p.x_mm - a.x_mm) * y - (p.y_mm - a.y_mm) * x) > sagitta_mm * length) return false;
    }
    return true;
  };
  std::vector<Point2> points{rounded_to(at(0), decimals)};
  for (int from = 0; from < kFine;) {
    int to = from + 1;
    for (int more = 1; to + more <= kFine && stays(from, to + more); more = 1 + (to - from) / 16) to += more;
    points.push_back(rounded_to(at(to), decimals));
    from = to;
  }
  return points;
}

/// Samples about `step_mm` apart along the curve (each by its own share of +-uneven), rounded to decimals.
inline std::vector<Point2> sampled(const ParametricCurve& curve, double step_mm, int decimals,
                                   double uneven = 0.0, std::uint64_t seed = 1) {
  constexpr int kFine = 20000;
  RandomStream draw(seed, Purpose::kTest);
  std::vector<double> along{0.0};
  Point2 before = curve(0.0);
  for (int i = 1; i <= kFine; ++i) {
    const Point2 p = curve(double(i) / kFine);
    along.push_back(along.back() + distance(before, p));
    before = p;
  }
  const int n = std::max(2, int(std::lround(along.back() / step_mm)));
  std::vector<Point2> points;
  std::size_t k = 0;
  for (int i = 0; i <= n; ++i) {
    const double shift = i == 0 || i == n ? 0.0 : uneven * draw.uniform(-0.5, 0.5);
    const double s = along.back() * (i + shift) / n;
    while (k + 2 < along.size() && along[k + 1] < s) ++k;
    const double x = along[k + 1] > along[k] ? (s - along[k]) / (along[k + 1] - along[k]) : 0.0;
    points.push_back(rounded_to(curve((double(k) + x) / kFine), decimals));
  }
  return points;
}

}  // namespace firn::motion
