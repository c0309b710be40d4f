// The deviation's bound against the discrete Frechet distance of dense samples [Eiter, Mannila 1994].
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/grid/random.h"
#include "core/motion/curve/frechet.h"

namespace firn::motion {
namespace {

/// A curve through points of a function at equal parameters.
template <class F>
Curve curve_of(F&& f, int cells, double total) {
  Curve c;
  std::vector<double> sweep;
  for (int i = 0; i <= cells; ++i) {
    const double s = total * i / cells;
    const Point2 p = f(s);
    c.s.push_back(s);
    c.x.push_back(p.x_mm);
    c.y.push_back(p.y_mm);
  }
  spline(c.s, c.x, 0.0, 0.0, c.xx, sweep);
  spline(c.s, c.y, 0.0, 0.0, c.yy, sweep);
  return c;
}

std::vector<Point2> dense(const Curve& c, int each) {
  std::vector<Point2> points;
  for (std::size_t i = 0; i < c.cells(); ++i)
    for (int k = 0; k < each; ++k) points.push_back(c.at(i, c.s[i] + (c.s[i + 1] - c.s[i]) * k / each));
  points.push_back({c.x.back(), c.y.back()});
  return points;
}

std::vector<Point2> dense(const std::vector<Point2>& polygon, double step) {
  std::vector<Point2> points;
  for (std::size_t i = 0; i + 1 < polygon.size(); ++i) {
    const int n = std::max(1, int(distance(polygon[i], polygon[i + 1]) / step));
    for (int k = 0; k < n; ++k)
      points.push_back({polygon[i].x_mm + (polygon[i + 1].x_mm - polygon[i].x_mm) * k / n,
                        polygon[i].y_mm + (polygon[i + 1].y_mm - polygon[i].y_mm) * k / n});
  }
  points.push_back(polygon.back());
  return points;
}

double discrete_frechet(const std::vector<Point2>& a, const std::vector<Point2>& b) {
  std::vector<double> row(b.size(), 1e300);
  for (std::size_t i = 0; i < a.size(); ++i) {
    double diagonal = 1e300;
    for (std::size_t k = 0; k < b.size(); ++k) {
      double least = std::min(row[k], k > 0 ? row[k - 1] : 1e300);
      least = std::min(least, diagonal);
      if (i == 0 && k == 0) least = 0.0;
      diagonal = row[k];
      row[k] = std::max(least, distance(a[i], b[k]));
    }
  }
  return row.back();
}

}  // namespace

TEST_CASE("The deviation is an upper bound of the Frechet distance, and a close one on smooth curves") {
  RandomStream draw(5, Purpose::kTest);
  for (int trial = 0; trial < 30; ++trial) {
    const double a = draw.uniform(0.5, 4.0), f = draw.uniform(0.1, 0.6), step = draw.uniform(0.3, 2.0),
                 noise = draw.uniform(0.0, 0.05);
    const Curve curve = curve_of([&](double s) { return Point2{s, a * std::sin(f * s)}; }, 60, 20.0);
    std::vector<Point2> polygon{{curve.x.front(), curve.y.front()}};
    for (double s = step; s < 19.9; s += step)
      polygon.push_back(
          {s + noise * draw.uniform(-1.0, 1.0), a * std::sin(f * s) + noise * draw.uniform(-1.0, 1.0)});
    polygon.push_back({curve.x.back(), curve.y.back()});
    const double bound = frechet_bound(curve, polygon);
    const double truth = discrete_frechet(dense(curve, 20), dense(polygon, 0.02));
    INFO("trial " << trial);
    CHECK(bound > truth - 0.02);  // samples 0.02 mm apart
    CHECK(bound < 1.3 * truth + 0.02);
  }
}

TEST_CASE(
    "A curve that leaves out a spike is as far off as the spike is long, though near it at every point") {
  const Curve curve = curve_of([](double s) { return Point2{s, 0.0}; }, 40, 20.0);
  CHECK(std::abs(frechet_bound(curve, std::vector<Point2>{{0, 0}, {10, 0}, {10, 3}, {10, 0}, {20, 0}}) -
                 3.0) < 0.01);
  // to and fro along the same line: each point of either lies on the other
  const double back = frechet_bound(curve, std::vector<Point2>{{0, 0}, {12, 0}, {8, 0}, {20, 0}});
  CHECK(back >= 2.0);
  CHECK(back <= 4.0 + 1e-3);
}

TEST_CASE("The stretches beyond a limit are where the curve is further off, and say by how much") {
  RandomStream draw(6, Purpose::kTest);
  for (int trial = 0; trial < 30; ++trial) {
    // a line with bumps: as far off as it is high
    std::vector<double> at, height;
    for (double s = draw.uniform(2.0, 4.0); s < 56.0; s += draw.uniform(5.0, 9.0)) {
      at.push_back(s);
      height.push_back(draw.uniform(0.0, 0.2));
    }
    const auto bump = [&](double s) {
      double y = 0.0;
      for (std::size_t i = 0; i < at.size(); ++i) y += height[i] * std::exp(-4.0 * (s - at[i]) * (s - at[i]));
      return y;
    };
    const Curve curve = curve_of([&](double s) { return Point2{s, bump(s)}; }, 600, 60.0);
    const std::vector<Point2> polygon{{0.0, curve.y.front()}, {60.0, curve.y.back()}};
    constexpr double kLimit = 0.1, kNear = 0.003;
    std::vector<StretchBeyond> found;
    find_stretches_beyond(curve, polygon, kLimit, found);
    double most = 0.0;
    bool missed = false, false_one = false;
    for (double s = 0.01; s < 60.0; s += 0.02) {
      const auto holds = [&](const StretchBeyond& x) { return x.from <= s && s <= x.to; };
      const bool inside = std::any_of(found.begin(), found.end(), holds);
      missed = missed || (bump(s) > kLimit + kNear && !inside);
      // a stretch is a whole cell, over which a bump falls by at most 0.035
      false_one = false_one || (inside && bump(s) < 0.6 * kLimit);
    }
    for (const StretchBeyond& x : found) most = std::max(most, x.beyond_mm);
    INFO("trial " << trial);
    CHECK_FALSE(missed);
    CHECK_FALSE(false_one);
    const double all = frechet_bound(curve, polygon);
    CHECK(std::abs(most - std::max(0.0, all - kLimit)) < 0.02 * all);
  }
}

TEST_CASE("A chord of a circle is off by its sagitta, the chord's end by nothing") {
  Curve curve = curve_of(
      [](double s) {
        return Point2{10.0 * std::cos(0.1 * s), 10.0 * std::sin(0.1 * s)};
      },
      200, 5.0 * std::numbers::pi);
  std::vector<Point2> polygon;
  for (int i = 0; i <= 10; ++i) {
    const double a = 0.05 * std::numbers::pi * i;
    polygon.push_back({10.0 * std::cos(a), 10.0 * std::sin(a)});
  }
  const double sagitta = 10.0 * (1.0 - std::cos(0.025 * std::numbers::pi));
  CHECK(std::abs(frechet_bound(curve, polygon) - sagitta) < 0.02 * sagitta);
}

}  // namespace firn::motion
