// Splines of least third derivative inside a tube: inside it, smooth, optimal, however the path was sampled.
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/grid/random.h"
#include "core/motion/curve/polyline_thinning.h"
#include "core/motion/curve/tube_fit.h"
#include "tests/core/motion/sampled_curves.h"

namespace firn::motion {
namespace {

double to_segment(Point2 p, Point2 a, Point2 b) {
  const double ux = b.x_mm - a.x_mm, uy = b.y_mm - a.y_mm, l = ux * ux + uy * uy;
  const double x =
      l > 0.0 ? std::clamp(((p.x_mm - a.x_mm) * ux + (p.y_mm - a.y_mm) * uy) / l, 0.0, 1.0) : 0.0;
  return std::hypot(p.x_mm - a.x_mm - x * ux, p.y_mm - a.y_mm - x * uy);
}

/// Largest distance of the curve's dense samples from the polygon.
double off(const Curve& curve, const std::vector<Point2>& points) {
  double most = 0.0;
  for (std::size_t i = 0; i < curve.cells(); ++i)
    for (int k = 0; k < 8; ++k) {
      const Point2 p = curve.at(i, curve.s[i] + (curve.s[i + 1] - curve.s[i]) * k / 8.0);
      double least = 1e300;
      for (std::size_t j = 0; j + 1 < points.size(); ++j)
        least = std::min(least, to_segment(p, points[j], points[j + 1]));
      most = std::max(most, least);
    }
  return most;
}

double energy(const Curve& curve) {
  double sum = 0.0;
  for (std::size_t i = 0; i < curve.cells(); ++i) {
    const double h = curve.s[i + 1] - curve.s[i], x = curve.xx[i + 1] - curve.xx[i],
                 y = curve.yy[i + 1] - curve.yy[i];
    sum += (x * x + y * y) / h;
  }
  return sum;
}

}  // namespace

TEST_CASE(
    "A fitted spline stays inside the tube, starts and ends at the path's ends, and bends no more than the "
    "curve") {
  TubeWork work;
  for (int kind = 0; kind < kCurveKinds; ++kind)
    for (const double step : {0.1, 0.5, 1.5}) {
      const std::vector<Point2> points = sampled(random_curve(kind, 3), step, 3, 0.5);
      Curve curve;
      fit_tube(points, {0.03, 0.03}, work, curve);
      INFO(kCurveKind[kind] << ", step " << step);
      CHECK(work.iterations < 30);
      CHECK(off(curve, points) <= 0.0301);
      CHECK(distance({curve.x.front(), curve.y.front()}, points.front()) < 1e-9);
      CHECK(distance({curve.x.back(), curve.y.back()}, points.back()) < 1e-9);
    }
}

TEST_CASE("The energy of the fit depends on the curve and the tolerance, not on the sampling") {
  TubeWork work;
  for (const int kind : {0, 2, 3}) {
    const ParametricCurve curve = random_curve(kind, 5);
    Curve fine, coarse, rounded;
    fit_tube(sampled(curve, 0.05, 9), {0.05, 0.05}, work, fine);
    fit_tube(sampled(curve, 0.3, 9), {0.05, 0.05}, work, coarse);
    fit_tube(sampled(curve, 0.05, 3), {0.05, 0.05}, work, rounded);
    INFO(kCurveKind[kind]);
    CHECK(std::abs(energy(coarse) / energy(fine) - 1.0) < 0.15);
    CHECK(std::abs(energy(rounded) / energy(fine) - 1.0) < 0.15);
  }
}

TEST_CASE("A wider tube never costs energy") {
  TubeWork work;
  for (int kind = 0; kind < kCurveKinds; ++kind) {
    const std::vector<Point2> points = sampled(random_curve(kind, 8), 0.3, 4);
    double before = 1e300;
    for (const double radius : {0.005, 0.01, 0.02, 0.05, 0.1}) {
      Curve curve;
      fit_tube(points, {radius, radius}, work, curve);
      INFO(kCurveKind[kind] << ", radius " << radius);
      CHECK(energy(curve) < 1.1 * before);
      before = energy(curve);
    }
  }
}

TEST_CASE("No spline near the fitted one, with its knots and inside its radii, has less energy") {
  RandomStream draw(9, Purpose::kTest);
  TubeWork work;
  const std::vector<Point2> points = sampled(random_curve(0, 11), 0.8, 9);
  Curve curve;
  fit_tube(points, {0.02, 0.02}, work, curve);
  const std::vector<Point2> best = work.control;
  const auto value = [&](const std::vector<Point2>& control) {
    double sum = 0.0;
    for (std::size_t k = 0; k < work.form.size(); ++k) {
      double x = 0.0, y = 0.0;
      for (std::size_t a = 0; a < 4; ++a) {
        x += work.form[k][a] * (control[k + a].x_mm - control[k].x_mm);
        y += work.form[k][a] * (control[k + a].y_mm - control[k].y_mm);
      }
      sum += x * x + y * y;
    }
    return sum;
  };
  const auto inside = [&](const std::vector<Point2>& control) {
    for (const TubeWork::Row& row : work.rows) {
      Point2 p{-row.at.x_mm, -row.at.y_mm};
      for (std::size_t a = 0; a < 4; ++a) {
        p.x_mm += row.basis[a] * control[row.first + a].x_mm;
        p.y_mm += row.basis[a] * control[row.first + a].y_mm;
      }
      if ((p.x_mm * p.x_mm + p.y_mm * p.y_mm) * row.over_square > 1.0) return false;
    }
    return true;
  };
  const double least = value(best);
  int tried = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    std::vector<Point2> other = best;
    const std::size_t from = 1 + draw.below(best.size() - 6);
    const double scale = 1e-3 * std::pow(10.0, draw.uniform(-3.0, 0.0));
    for (std::size_t k = from; k < from + 4; ++k) {
      other[k].x_mm += scale * draw.uniform(-1.0, 1.0);
      other[k].y_mm += scale * draw.uniform(-1.0, 1.0);
    }
    if (!inside(other)) continue;
    ++tried;
    CHECK(value(other) > 0.97 * least);  // the duality gap at which the iteration ends
  }
  CHECK(tried > 500);
}

TEST_CASE("A tube that is narrowed about a stretch brings the spline nearer there, and leaves the rest") {
  TubeWork work;
  const std::vector<Point2> points = sampled(random_curve(0, 8), 0.3, 4);
  Curve before, after;
  fit_tube(points, {0.05, 0.05}, work, before);
  const double total = before.s.back(), from = 0.4 * total, to = 0.42 * total, beyond = 0.02;
  narrow_tube(std::vector<StretchBeyond>{{from, to, beyond}}, 0.005, work);
  refit_tube(work, after);
  std::size_t narrower = 0;
  for (const TubePlace& place : work.places) {
    const Curve& c = after;
    const std::size_t cell = std::min(
        c.cells() - 1, std::size_t(std::upper_bound(c.s.begin(), c.s.end(), place.t) - c.s.begin()) - 1);
    const double off_mm = distance(c.at(cell, place.t), place.at);
    CHECK(off_mm <= 1.0001 * place.radius);
    if (place.t >= from && place.t <= to) {
      ++narrower;
      CHECK(off_mm <= 0.026);
    } else if (place.t < 0.3 * total || place.t > 0.52 * total) {
      CHECK(place.radius > 0.04);
    }
  }
  CHECK(narrower > 0);
}

TEST_CASE("A step of descent whose weights are large leaves a curve at the tube's edge where it is") {
  TubeWork work;
  const double radius = 0.05;
  Curve curve;
  fit_tube(sampled(random_curve(5, 3), 0.2, 4), {.radius_mm = radius, .between_mm = radius}, work, curve);
  work.base = work.control;
  const std::size_t cells = curve.cells();
  RandomStream draw(3, Purpose::kTest);
  std::vector<double> none(2 * cells, 0.0), third(2 * cells);
  for (double& g : third) g = 1e-6 * draw.uniform(-1.0, 1.0);
  for (const double weight : {1e4, 1e6}) {
    step_tube(curve, {{none, none, third}, {none, none, third}}, std::vector<double>(cells + 1, weight), 1.0,
              work, curve);
    double moved = 0.0;
    for (std::size_t i = 0; i < work.base.size(); ++i)
      moved = std::max(moved, distance(work.base[i], work.control[i]));
    INFO("weight " << weight);
    CHECK(moved < 1e-3 * radius);
  }
}

TEST_CASE("Between samples of an arc the tube is as wide as two sagittas, beside a line as ever") {
  constexpr double kRadius = 6.0, kChord = 2.0, kBetween = 0.03, kMost = 0.18;
  const double angle = 2.0 * std::asin(0.5 * kChord / kRadius);
  std::vector<Point2> points;
  for (int i = 0; i < 6; ++i) points.push_back({kChord * i - 12.0, 0.0});
  for (int i = 0; i < 10; ++i)
    points.push_back({kRadius * std::sin(angle * i), kRadius * (1.0 - std::cos(angle * i))});
  TubeWork work;
  Curve curve;
  fit_tube(points, {.radius_mm = 1e-4, .between_mm = kBetween, .max_between_mm = kMost}, work, curve);
  const double sagitta = kRadius * (1.0 - std::cos(0.5 * angle));
  int on_line = 0, on_arc = 0;
  for (const TubePlace& place : work.places) {
    if (place.radius < kBetween) continue;  // a sample
    const double chord = place.t / kChord;
    if (chord < 6.0) {
      ++on_line;
      CHECK(std::abs(place.radius - kBetween) < 1e-12);
    } else if (chord > 7.0 && chord < 14.0) {
      ++on_arc;
      CHECK(std::abs(place.radius - std::min(kMost, 2.0 * sagitta)) < 0.02 * sagitta);
    }
  }
  CHECK(on_line > 5);
  CHECK(on_arc > 5);
}

TEST_CASE("Rounded samples of a line are a line") {
  std::vector<Point2> points;
  for (int i = 0; i <= 1000; ++i)
    points.push_back({std::round(70.7107 * i) / 1000.0, std::round(31.234 * i) / 1000.0});
  TubeWork work;
  Curve curve;
  fit_tube(points, {0.005, 0.005}, work, curve);
  CHECK(curve.straight);
}

TEST_CASE("Points held within their own rounding: the spline passes them, and is smooth where they scatter") {
  TubeWork work;
  const ParametricCurve ellipse = random_curve(2, 4);
  const std::vector<Point2> points = sampled(ellipse, 0.2, 3);
  Curve curve;
  fit_tube(points, {0.0005, 0.03}, work, curve);
  Curve exact;
  fit_tube(sampled(ellipse, 0.2, 9), {0.0005, 0.03}, work, exact);
  for (const Point2& p : points) {
    double least = 1e300;
    for (std::size_t i = 0; i < curve.cells(); ++i)
      for (int k = 0; k <= 64; ++k)
        least =
            std::min(least, distance(p, curve.at(i, curve.s[i] + (curve.s[i + 1] - curve.s[i]) * k / 64.0)));
    CHECK(least < 0.0005 + 0.004);  // samples of the curve lie up to 0.008 apart
  }
  CHECK(energy(curve) < 3.0 * energy(exact));
}

TEST_CASE("A thinned polygon has few vertices and leaves none out that is further off than allowed") {
  RandomStream draw(2, Purpose::kTest);
  for (int trial = 0; trial < 40; ++trial) {
    const std::vector<Point2> points =
        sampled(random_curve(int(draw.below(kCurveKinds)), std::uint64_t(trial)), 0.05, 3);
    const double within = 0.001 * std::pow(30.0, draw.uniform(0.0, 1.0));
    std::vector<std::size_t> kept;
    thin_polyline(points, within, kept);
    REQUIRE(kept.front() == 0);
    REQUIRE(kept.back() == points.size() - 1);
    INFO("trial " << trial << ", within " << within);
    for (std::size_t k = 0; k + 1 < kept.size(); ++k)
      for (std::size_t i = kept[k]; i <= kept[k + 1]; ++i)
        CHECK(to_segment(points[i], points[kept[k]], points[kept[k + 1]]) <= 2.0 * within);
    CHECK(kept.size() < points.size());
  }
}

}  // namespace firn::motion
