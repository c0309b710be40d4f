// Computes random paths whose points a curve has to pass, drawn from a seed, and how far a curve is from them
// by dense sampling, with formulas of its own: lines into dense samples, slight corners, uneven spacing,
// joints that are nearly tangent, corners, closed curves, points that follow each other twice.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/grid/random.h"
#include "core/motion/certified/certified.h"
#include "core/path/path.h"

namespace firn::motion {

struct HeldPath {
  std::vector<Point2> points;
  const char* kind = "";
  int decimals = 9;
};

class HeldPathMaker {
 public:
  explicit HeldPathMaker(std::uint64_t seed) : draw_(seed, Purpose::kTest) {}

  HeldPath next() {
    static constexpr int kDecimals[3] = {3, 4, 9};
    HeldPath path;
    path.decimals = kDecimals[draw_.below(3)];
    points_.assign(1, {0.0, 0.0});
    heading_ = draw_.uniform(0.0, 6.28);
    switch (draw_.below(6)) {
      case 0:
        path.kind = "line into dense samples";
        line(draw_.uniform(1.0, 30.0));
        bend(draw_.uniform(0.5, 15.0), draw_.uniform(0.02, 0.3), 0.0, draw_.uniform(0.0, 0.4));
        if (draw_.below(2)) line(draw_.uniform(0.5, 20.0));
        break;
      case 1:
        path.kind = "slight corners";
        for (int k = 2 + int(draw_.below(8)); k > 0; --k) {
          line(draw_.uniform(0.1, 20.0));
          heading_ += std::pow(10.0, draw_.uniform(-4.0, -0.3)) * (draw_.below(2) ? 1.0 : -1.0);
        }
        break;
      case 2:
        path.kind = "uneven spacing";
        for (int k = 1 + int(draw_.below(3)); k > 0; --k)
          bend(draw_.uniform(2.0, 20.0), draw_.uniform(0.05, 0.6), 0.8, draw_.uniform(-0.3, 0.3));
        break;
      case 3:
        path.kind = "nearly tangent joints";
        for (int k = 2 + int(draw_.below(4)); k > 0; --k) {
          draw_.below(2) ? line(draw_.uniform(2.0, 20.0)) : arc();
          heading_ += draw_.below(3) ? std::pow(10.0, draw_.uniform(-7.0, -1.5)) : 0.0;
        }
        break;
      case 4:
        path.kind = "closed";
        close();
        break;
      default:
        path.kind = "corners";
        for (int k = 2 + int(draw_.below(4)); k > 0; --k) {
          draw_.below(2)
              ? line(draw_.uniform(0.5, 15.0))
              : bend(draw_.uniform(1.0, 8.0), draw_.uniform(0.05, 0.4), 0.2, draw_.uniform(-0.3, 0.3));
          heading_ += draw_.uniform(-2.5, 2.5);
        }
    }
    const double unit = std::pow(10.0, path.decimals);
    for (const Point2& p : points_) {
      path.points.push_back({std::round(p.x_mm * unit) / unit, std::round(p.y_mm * unit) / unit});
      if (draw_.below(40) == 0) path.points.push_back(path.points.back());
    }
    return path;
  }

 private:
  void step(double length) {
    const Point2 p = points_.back();
    points_.push_back({p.x_mm + length * std::cos(heading_), p.y_mm + length * std::sin(heading_)});
  }
  void line(double length) { step(length); }
  /// Samples whose curvature changes linearly to `last`.
  void bend(double length, double spacing, double uneven, double last) {
    double at = 0.0;
    while (at < length) {
      const double h = spacing * (1.0 + uneven * draw_.uniform(-1.0, 1.0));
      heading_ += 0.5 * h * last * at / length;
      step(h);
      heading_ += 0.5 * h * last * at / length;
      at += h;
    }
  }
  void arc() {
    const double radius = draw_.uniform(0.5, 40.0) * (draw_.below(2) ? 1.0 : -1.0),
                 angle = draw_.uniform(0.1, 3.0);
    const int n = std::max(4, int(std::abs(radius) * angle / 0.3));
    const double turn = std::copysign(angle / n, radius);
    for (int i = 0; i < n; ++i) {
      heading_ += 0.5 * turn;
      step(2.0 * std::abs(radius * std::sin(0.5 * turn)));
      heading_ += 0.5 * turn;
    }
  }
  void close() {
    const double a = draw_.uniform(3.0, 20.0), b = draw_.uniform(3.0, 20.0), lobes = draw_.uniform(0.0, 0.15);
    const int n = int(6.0 * std::max(a, b) / draw_.uniform(0.1, 0.7));
    points_.clear();
    for (int i = 0; i <= n; ++i) {
      const double w = 2.0 * std::numbers::pi * (i % n) / n, r = 1.0 + lobes * std::cos(3.0 * w);
      points_.push_back({a * r * std::cos(w), b * r * std::sin(w)});
    }
  }

  RandomStream draw_;
  std::vector<Point2> points_;
  double heading_ = 0.0;
};

struct HeldDistances {
  double points_mm = 0.0;  ///< largest distance of a point from the curve
  double curve_mm = 0.0;   ///< and of a sample of the curve from the polygon
};

/// @param told_mm the first place that is so near to a point, but for the chords' sagitta, goes with it
/// @param points as planned, in the arm's base frame; their last may be that of the first segment's start
inline HeldDistances sampled_distances(const std::vector<Point2>& points,
                                       const std::vector<StopSegment>& segments, std::size_t count,
                                       double told_mm = 0.0) {
  constexpr int kParts = 48;
  std::vector<Point2> curve;
  for (std::size_t k = 0; k < count; ++k) {
    const Curve& c = segments[k].curve;
    for (std::size_t i = 0; i < c.cells(); ++i)
      for (int j = 0; j < kParts; ++j) {
        const double h = c.s[i + 1] - c.s[i], u = double(j) / kParts, v = 1.0 - u;
        const auto axis = [&](const std::vector<double>& f, const std::vector<double>& m) {
          return v * f[i] + u * f[i + 1] +
                 h * h / 6.0 * ((v * v * v - v) * m[i] + (u * u * u - u) * m[i + 1]);
        };
        curve.push_back({axis(c.x, c.xx), axis(c.y, c.yy)});
      }
    if (k + 1 == count) curve.push_back({c.x.back(), c.y.back()});
  }
  const auto off = [](Point2 p, Point2 a, Point2 b) {
    const double ux = b.x_mm - a.x_mm, uy = b.y_mm - a.y_mm, square = ux * ux + uy * uy;
    const double x = square > 0.0 ? ((p.x_mm - a.x_mm) * ux + (p.y_mm - a.y_mm) * uy) / square : 0.0;
    const double y = std::clamp(x, 0.0, 1.0);
    return std::hypot(p.x_mm - a.x_mm - y * ux, p.y_mm - a.y_mm - y * uy);
  };
  // both are in order: each search goes on from where the one before it ended, and looks some way ahead
  constexpr double kPointAhead_mm = 3.0, kCurveAhead_mm = 0.5, kChordSagitta_mm = 5e-6;
  const auto farthest = [&](const std::vector<Point2>& of, const std::vector<Point2>& from, double most_mm,
                            double enough) {
    double most = 0.0;
    std::size_t at = 0;
    for (std::size_t n = 0; n < of.size(); ++n) {
      const double ahead = most_mm + (n > 0 ? 2.0 * distance(of[n - 1], of[n]) : 0.0);
      double least = 1e300, gone = 0.0;
      std::size_t best = at;
      for (std::size_t i = at; i + 1 < from.size() && gone <= ahead; ++i) {
        gone += i > at ? distance(from[i], from[i + 1]) : 0.0;
        const double d = off(of[n], from[i], from[i + 1]);
        if (d < least - 1e-12) {
          least = d;
          best = i;
        }
        if (least <= enough) break;  // a path that turns back passes its points again
      }
      at = best;
      most = std::max(most, least);
    }
    return most;
  };
  return {farthest(points, curve, kPointAhead_mm, told_mm + kChordSagitta_mm),
          farthest(curve, points, kCurveAhead_mm, 0.0)};
}

}  // namespace firn::motion
