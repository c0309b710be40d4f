// Isotonic regression, and the distances of points from a curve in order, against brute force.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/grid/random.h"
#include "core/motion/curve/frechet.h"
#include "core/motion/curve/in_order.h"

namespace firn::motion {
namespace {

/// Least over all assignments in order of the largest distance of a point from its place among `curve`.
double least_in_order(const std::vector<Point2>& points, const std::vector<Point2>& curve) {
  std::vector<double> least(curve.size(), 0.0);  // of those whose last place is not behind this one
  for (const Point2& p : points)
    for (std::size_t k = 0; k < curve.size(); ++k) {
      const double here = std::max(least[k], distance(p, curve[k]));
      least[k] = k > 0 ? std::min(here, least[k - 1]) : here;
    }
  return least.back();
}

}  // namespace

TEST_CASE("Numbers put in order do not fall, and move by half of the largest fall: no less would do") {
  RandomStream draw(3, Purpose::kTest);
  for (int round = 0; round < 200; ++round) {
    std::vector<double> values(1 + draw.below(40));
    double level = 0.0;
    for (double& v : values) v = level += draw.uniform(-1.0, 2.0);
    std::vector<double> sorted = values;
    put_in_order(sorted);
    CHECK(std::is_sorted(sorted.begin(), sorted.end()));
    double fall = 0.0, moved = 0.0;
    for (std::size_t i = 0; i < values.size(); ++i) {
      for (std::size_t k = i; k < values.size(); ++k) fall = std::max(fall, values[i] - values[k]);
      moved = std::max(moved, std::abs(sorted[i] - values[i]));
    }
    CHECK(moved == Approx(0.5 * fall).margin(1e-12));
  }
}

TEST_CASE("Numbers in order stay as they are") {
  std::vector<double> values{0.1, 0.1, 0.3, 7.0};
  const std::vector<double> before = values;
  put_in_order(values);
  CHECK(values == before);
}

TEST_CASE("Rounded samples are as far from their curve as the best places in order, where it turns tightly") {
  RandomStream draw(4, Purpose::kTest);
  constexpr double kUnit_mm = 1e-3, kStep_mm = 2e-6;
  for (int round = 0; round < 40; ++round) {
    // half a turn of some micrometres, as beside a cusp, between two lines
    const double radius = draw.uniform(0.003, 0.03), start = draw.uniform(0.0, 6.28),
                 spacing = draw.uniform(3e-4, 4e-3);
    const double x = draw.uniform(0.0, kUnit_mm), y = draw.uniform(0.0, kUnit_mm);
    const auto at = [&](double s) {
      const double turn = std::clamp(s / radius, 0.0, std::numbers::pi), line = s - turn * radius;
      return Point2{x + radius * (std::sin(start + turn) - std::sin(start)) + line * std::cos(start + turn),
                    y - radius * (std::cos(start + turn) - std::cos(start)) + line * std::sin(start + turn)};
    };
    const double from = -0.02, to = std::numbers::pi * radius + 0.02;
    Curve curve;
    std::vector<double> sweep;
    const int cells = int((to - from) / (0.05 * radius));
    for (int i = 0; i <= cells; ++i) {
      const double s = (to - from) * i / cells;
      curve.s.push_back(s);
      curve.x.push_back(at(from + s).x_mm);
      curve.y.push_back(at(from + s).y_mm);
    }
    spline(curve.s, curve.x, 0.0, 0.0, curve.xx, sweep);
    spline(curve.s, curve.y, 0.0, 0.0, curve.yy, sweep);
    std::vector<Point2> points{{curve.x.front(), curve.y.front()}}, dense;
    for (double s = from + spacing; s < to; s += spacing) {
      const Point2 p{kUnit_mm * std::round(at(s).x_mm / kUnit_mm),
                     kUnit_mm * std::round(at(s).y_mm / kUnit_mm)};
      if (distance(p, points.back()) > 0.0) points.push_back(p);
    }
    points.push_back({curve.x.back(), curve.y.back()});
    std::size_t cell = 0;
    for (double s = 0.0; s < curve.s.back(); s += kStep_mm) {
      while (cell + 1 < curve.cells() && s >= curve.s[cell + 1]) ++cell;
      dense.push_back(curve.at(cell, s));
    }
    const double found = farthest_point_mm(curve, points, std::numbers::sqrt2 / 2.0 * kUnit_mm);
    points.erase(points.begin());
    points.pop_back();
    const double least = least_in_order(points, dense);
    INFO("round " << round << ", radius " << radius << ", spacing " << spacing);
    CHECK(found >= least - kStep_mm);
    CHECK(found <= 1.1 * least);
  }
}

}  // namespace firn::motion
