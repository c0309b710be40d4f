// Computes random paths that a planner must plan or refuse, drawn from a seed: cusps, tight arcs, repeated
// points, dense and sparse points, tiny paths, paths that come within 0.1 mm of the stretched arm.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/grid/random.h"
#include "core/path/path.h"

namespace firn::motion {

struct RandomPath {
  std::vector<Point2> points;  ///< in the arm's base frame
  const char* kind = "";
};

class RandomPathMaker {
 public:
  explicit RandomPathMaker(std::uint64_t seed) : draw_(seed, Purpose::kTest) {}

  RandomPath next() {
    RandomPath path;
    switch (draw_.below(8)) {
      case 0:
        path = {lines_and_arcs(0.4, 2.0, 30.0), "lines and arcs"};
        break;
      case 1:
        path = {lines_and_arcs(0.1, 0.2, 2.0), "tight arcs"};
        break;
      case 2:
        path = {polygon(0.05, 20.0, 3.2), "polygon with cusps"};
        break;
      case 3:
        path = {polygon(0.2, 1.5, 0.5), "dense bent polygon"};
        break;
      case 4:
        path = {smooth(), "smooth"};
        break;
      case 5:
        path = {polygon(1e-4, 0.5, 3.2), "tiny"};
        break;
      case 6:
        path = {zigzag(), "zigzag"};
        break;
      default:
        path = {lines_and_arcs(0.4, 5.0, 100.0), "large arcs"};
        break;
    }
    if (draw_.below(4) == 0) repeat_some(path.points);
    place(path.points);
    return path;
  }

 private:
  std::vector<Point2> lines_and_arcs(double spacing, double least_radius, double most_radius) {
    std::vector<Point2> points{{0, 0}};
    double heading = draw_.uniform(0.0, 6.28);
    const int pieces = 1 + int(draw_.below(6));
    for (int k = 0; k < pieces; ++k) {
      const bool arc = draw_.below(2) == 0;
      const double radius = draw_.uniform(least_radius, most_radius) * (draw_.below(2) ? 1.0 : -1.0);
      const double length = arc ? std::abs(radius) * draw_.uniform(0.2, 4.0) : draw_.uniform(0.5, 40.0);
      const int n = std::max(1, int(std::lround(length / spacing)));
      for (int i = 0; i < n; ++i) {
        const double turn = arc ? length / n / radius : 0.0,
                     chord = arc ? 2.0 * radius * std::sin(0.5 * turn) : length / n;
        const Point2 p = points.back();
        points.push_back({p.x_mm + chord * std::cos(heading + 0.5 * turn),
                          p.y_mm + chord * std::sin(heading + 0.5 * turn)});
        heading += turn;
      }
      if (draw_.below(4) == 0) heading += draw_.uniform(-3.2, 3.2);
    }
    return points;
  }
  std::vector<Point2> polygon(double shortest, double longest, double turn) {
    std::vector<Point2> points{{0, 0}};
    double heading = draw_.uniform(0.0, 6.28);
    const int n = 1 + int(draw_.below(30));
    for (int i = 0; i < n; ++i) {
      const double length = draw_.uniform(shortest, longest);
      const Point2 p = points.back();
      points.push_back({p.x_mm + length * std::cos(heading), p.y_mm + length * std::sin(heading)});
      heading += draw_.below(5) == 0 ? std::numbers::pi : draw_.uniform(-turn, turn);
    }
    return points;
  }
  std::vector<Point2> smooth() {
    std::vector<Point2> points;
    const int n = 20 + int(draw_.below(200));
    const double a = draw_.uniform(0.5, 8.0), b = draw_.uniform(0.1, 2.0), f = draw_.uniform(0.02, 0.2),
                 g = draw_.uniform(0.2, 0.9);
    for (int i = 0; i < n; ++i)
      points.push_back({0.4 * i, a * std::sin(f * i) + b * std::sin(g * f * 3.0 * i + 1.0)});
    return points;
  }
  std::vector<Point2> zigzag() {
    std::vector<Point2> points;
    const double width = draw_.uniform(1.0, 30.0), step = draw_.uniform(0.3, 2.0);
    for (int i = 0; i < 12; ++i) points.push_back({i % 4 == 1 || i % 4 == 2 ? width : 0.0, step * (i / 2)});
    return points;
  }
  void repeat_some(std::vector<Point2>& points) {
    std::vector<Point2> out;
    for (const Point2& p : points) {
      out.push_back(p);
      if (draw_.below(6) == 0) out.push_back(p);
    }
    points = out;
  }
  /// Somewhere in the arm's reach; one path in three touches 0.1 to 2 mm from full reach.
  void place(std::vector<Point2>& points) {
    const double angle = draw_.uniform(-1.2, 1.2);
    const bool far = draw_.below(3) == 0;
    const double reach = far ? 600.0 - draw_.uniform(0.1, 2.0) : draw_.uniform(320.0, 500.0);
    Point2 least = points[0], most = points[0];
    for (const Point2& p : points) {
      least = {std::min(least.x_mm, p.x_mm), std::min(least.y_mm, p.y_mm)};
      most = {std::max(most.x_mm, p.x_mm), std::max(most.y_mm, p.y_mm)};
    }
    const double span = std::max({most.x_mm - least.x_mm, most.y_mm - least.y_mm, 1e-9});
    const double scale = std::min(1.0, 120.0 / span), c = std::cos(angle), s = std::sin(angle);
    for (Point2& p : points)
      p = {(p.x_mm - least.x_mm) * scale, (p.y_mm - 0.5 * (least.y_mm + most.y_mm)) * scale};
    // push outward along +x until the furthest point reaches `reach`
    double push = 0.0;
    for (int pass = 0; pass < 60; ++pass) {
      double furthest = 0.0;
      for (const Point2& p : points) furthest = std::max(furthest, std::hypot(p.x_mm + push, p.y_mm));
      push += reach - furthest;
    }
    for (Point2& p : points) p = {c * (p.x_mm + push) - s * p.y_mm, s * (p.x_mm + push) + c * p.y_mm};
  }

  RandomStream draw_;
};

}  // namespace firn::motion
