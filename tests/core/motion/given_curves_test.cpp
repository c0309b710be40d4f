// Arcs and Bezier curves that a file gives as such are the curve that is driven, not its samples.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "core/grid/random.h"
#include "core/motion/certified/certified.h"
#include "core/motion/planner.h"

using namespace firn;
using namespace firn::motion;

namespace {

constexpr Point2 kGivenPart{400.0, 0.0};

struct GivenPath {
  std::vector<Point2> points;
  std::vector<GivenCurve> given;

  /// An arc from the last point on about a centre by an angle, > 0 anticlockwise.
  void arc(Point2 centre, double angle, int samples) {
    const Point2 from = points.back();
    const double radius = distance(centre, from),
                 start = std::atan2(from.y_mm - centre.y_mm, from.x_mm - centre.x_mm);
    GivenCurve curve;
    curve.first = points.size() - 1;
    curve.centre = centre;
    curve.clockwise = angle < 0.0;
    for (int i = 1; i <= samples; ++i) {
      const double a = start + angle * i / samples;
      points.push_back({centre.x_mm + radius * std::cos(a), centre.y_mm + radius * std::sin(a)});
    }
    curve.last = points.size() - 1;
    given.push_back(curve);
  }
};

PlanResult planned(const GivenPath& path, const PlanOptions& options, CertifiedWork& work) {
  static const auto arm = make_scara(cobra600());
  PathInput input;
  input.points = path.points;
  input.given = path.given;
  input.origin = kGivenPart;
  return plan_certified(input, *arm, cobra600_limits(), options, work);
}

/// Two lines that are tangent to a quarter of a circle.
GivenPath rounded_corner(double radius) {
  GivenPath path;
  path.points = {{-30.0, 0.0}, {0.0, 0.0}};
  path.arc({0.0, radius}, 0.5 * std::numbers::pi, 40);
  path.points.push_back({radius, radius + 30.0});
  return path;
}

}  // namespace

TEST_CASE("A given arc from rest to rest is its circle: at the knots to 1e-9 mm, between them to 1e-6") {
  CertifiedWork work;
  for (const double radius : {0.5, 5.0, 40.0}) {
    GivenPath path;
    path.points = {{radius, 0.0}};
    path.arc({}, 2.0 * std::numbers::pi, 90);
    const PlanResult result = planned(path, {}, work);
    CHECK(result.stops == 0);
    const Curve& curve = work.segments()[0].curve;
    const Curve& coarse = work.stops.segment.curve.curve.coarse;  // its knots are those that it was built of
    double at_knots = 0.0, between = 0.0;
    for (std::size_t i = 0; i < coarse.s.size(); ++i)
      at_knots = std::max(at_knots, std::abs(distance({coarse.x[i], coarse.y[i]}, kGivenPart) - radius));
    for (std::size_t i = 0; i < curve.cells(); ++i)
      between = std::max(
          between, std::abs(distance(curve.at(i, 0.5 * (curve.s[i] + curve.s[i + 1])), kGivenPart) - radius));
    INFO("radius " << radius);
    CHECK(at_knots < 1e-9);
    CHECK(between < 1e-6);
    CHECK(result.deviation_mm < 2e-5);
  }
}

namespace {

/// Largest distance of a place of the driven curves from the lines and arcs of a path.
double farthest_off(const GivenPath& path, const CertifiedWork& work, std::size_t segments) {
  std::vector<std::size_t> arc_of(path.points.size(), path.given.size());
  for (std::size_t k = 0; k < path.given.size(); ++k)
    for (std::size_t i = path.given[k].first; i < path.given[k].last; ++i) arc_of[i] = k;
  const auto off = [&](Point2 p) {
    double least = 1e300;
    for (std::size_t i = 0; i + 1 < path.points.size(); ++i) {
      const Point2 a = path.points[i], b = path.points[i + 1];
      const double ux = b.x_mm - a.x_mm, uy = b.y_mm - a.y_mm;
      const double along = ((p.x_mm - a.x_mm) * ux + (p.y_mm - a.y_mm) * uy) / (ux * ux + uy * uy);
      const double x = std::clamp(along, 0.0, 1.0);
      const Point2 foot{a.x_mm + x * ux, a.y_mm + x * uy};
      if (arc_of[i] == path.given.size() || along < 0.0 || along > 1.0) {
        least = std::min(least, distance(p, foot));
        continue;
      }
      const Point2 centre = path.given[arc_of[i]].centre;
      const double radius = distance(centre, a), away = std::abs(distance(centre, p) - radius);
      if (away < 0.5 * radius) least = std::min(least, away);
    }
    return least;
  };
  double most = 0.0;
  for (std::size_t k = 0; k < segments; ++k) {
    const Curve& curve = work.segments()[k].curve;
    for (std::size_t i = 0; i < curve.cells(); ++i)
      for (const double x : {0.0, 0.3, 0.7}) {
        const Point2 p = curve.at(i, curve.s[i] + x * (curve.s[i + 1] - curve.s[i]));
        most = std::max(most, off({p.x_mm - kGivenPart.x_mm, p.y_mm - kGivenPart.y_mm}));
      }
  }
  return most;
}

/// A line, an arc that turns by `angle` from a tangent that is `corner` off the line's, and a line tangent to
/// it.
GivenPath line_arc_line(double radius, double angle, double corner) {
  GivenPath path;
  path.points = {{-20.0, 0.0}, {0.0, 0.0}};
  const double side = angle < 0.0 ? -1.0 : 1.0, left = corner + side * 0.5 * std::numbers::pi;
  path.arc({radius * std::cos(left), radius * std::sin(left)}, angle,
           8 + int(std::abs(angle) * std::sqrt(radius / 8e-3)));
  const Point2 end = path.points.back();
  path.points.push_back(
      {end.x_mm + 15.0 * std::cos(corner + angle), end.y_mm + 15.0 * std::sin(corner + angle)});
  return path;
}

}  // namespace

TEST_CASE("Without a tolerance lines and given arcs of any radius, joined anyhow, stay within 0.12 um") {
  constexpr double kExactWithin_mm = 1.2e-4;
  CertifiedWork work;
  const auto check = [&](const GivenPath& path, const std::string& what) {
    const PlanResult result = planned(path, {}, work);
    INFO(what);
    CHECK(result.deviation_mm <= kExactWithin_mm);
    CHECK(farthest_off(path, work, result.stops + 1) <= result.deviation_mm + 1e-9);
    for (const LimitRatio& limit : result.trajectory.certificate.limits) CHECK(limit.ratio <= 1.0);
  };
  for (const double radius : {0.005, 0.01, 0.05, 0.5, 1.0, 5.0, 100.0}) {
    const double most = radius > 50.0 ? 0.5 : 2.0 * std::numbers::pi;
    for (const double angle :
         {1e-3, -0.1, 0.5 * std::numbers::pi, -3.0, 2.0 * std::numbers::pi - 1e-3, 2.0 * std::numbers::pi})
      for (const double corner : {0.0, 0.01, 0.4, 2.0})
        if (std::abs(angle) <= most)
          check(line_arc_line(radius, angle, corner), "radius " + std::to_string(radius) + " angle " +
                                                          std::to_string(angle) + " corner " +
                                                          std::to_string(corner));
    GivenPath both = line_arc_line(radius, std::min(most, 1.5), 0.0);  // two arcs, curved to either side
    both.points.pop_back();
    const Point2 end = both.points.back(), centre = both.given[0].centre;
    both.arc({2.0 * end.x_mm - centre.x_mm, 2.0 * end.y_mm - centre.y_mm}, -std::min(most, 1.5), 40);
    both.points.push_back({both.points.back().x_mm + 10.0, both.points.back().y_mm});
    check(both, "two arcs of radius " + std::to_string(radius));
  }
}

TEST_CASE("A given Bezier curve is driven to a nanometre, as its tick samples tell") {
  RandomStream draw(11, Purpose::kTest);
  CertifiedWork work;
  for (int trial = 0; trial < 10; ++trial) {
    GivenCurve curve;
    curve.kind = GivenCurve::Kind::kBezier;
    curve.start = {-20.0, draw.uniform(-5.0, 5.0)};
    curve.control[0] = {-8.0, draw.uniform(-20.0, 20.0)};
    curve.control[1] = {8.0, draw.uniform(-20.0, 20.0)};
    curve.end = {20.0, draw.uniform(-5.0, 5.0)};
    GivenPath path;
    constexpr int kSamples = 400;
    for (int i = 0; i <= kSamples; ++i) path.points.push_back(curve.at(double(i) / kSamples));
    curve.last = kSamples;
    path.given = {curve};
    const PlanResult result = planned(path, {}, work);
    double most = 0.0, u = 0.0;
    for (const Point2& p : result.tool) {
      for (int step = 0; step < 50; ++step) {  // Gauss-Newton on the distance
        constexpr double kStep = 1e-6;
        const Point2 a = curve.at(u - kStep), b = curve.at(u + kStep), at = curve.at(u);
        const double dx = (b.x_mm - a.x_mm) / (2.0 * kStep), dy = (b.y_mm - a.y_mm) / (2.0 * kStep);
        u -= ((at.x_mm - p.x_mm) * dx + (at.y_mm - p.y_mm) * dy) / (dx * dx + dy * dy);
      }
      most = std::max(most, distance(curve.at(u), p));
    }
    CHECK(most < 1e-6);
    CHECK(result.deviation_mm < 3e-5);
  }
}

TEST_CASE(
    "Lines and arcs that a Bezier curve joins, with a turn or without, stay within 0.12 um without a "
    "tolerance") {
  CertifiedWork work;
  for (const double size : {0.2, 1.0, 5.0, 20.0})
    for (const double turn : {0.0, 0.03, 0.3}) {
      GivenCurve curve;
      curve.kind = GivenCurve::Kind::kBezier;
      curve.control[0] = {0.55 * size * std::cos(turn), 0.55 * size * std::sin(turn)};
      curve.control[1] = {size, 0.45 * size};
      curve.end = {size, size};
      GivenPath path;
      path.points = {{-15.0, 0.0}, {0.0, 0.0}};
      const int samples = std::max(8, int(size / 0.1));
      for (int i = 1; i <= samples; ++i) path.points.push_back(curve.at(double(i) / samples));
      curve.first = 1;
      curve.last = path.points.size() - 1;
      path.given = {curve};
      path.arc({0.0, size}, 1.0, 60);
      const PlanResult result = planned(path, {}, work);
      INFO("size " << size << " turn " << turn);
      CHECK(result.stops == 0);
      CHECK(result.deviation_mm <= 1.2e-4);
    }
}

TEST_CASE("A given arc turns without a stop, however few and sharp its samples") {
  CertifiedWork work;
  GivenPath path;
  path.points = {{-10.0, 0.0}, {0.0, 0.0}};
  path.arc({0.0, 0.2}, std::numbers::pi, 4);  // 45 degrees between its chords
  path.points.push_back({-10.0, 0.4});
  CHECK(planned(path, {}, work).stops == 0);
  path.given.clear();
  CHECK(planned(path, {}, work).stops > 0);
}

TEST_CASE(
    "With a tolerance the curve stays within it of the given arcs, which are off their samples by 30 um") {
  CertifiedWork work;
  PlanOptions options;
  options.tolerance_mm = 0.01;
  GivenPath path;
  path.points = {{-30.0, 0.0}, {0.0, 0.0}};
  path.arc({0.0, 4.0}, 0.5 * std::numbers::pi, 6);  // sagitta 0.034 mm
  path.points.push_back({4.0, 34.0});
  const PlanResult result = planned(path, options, work);
  CHECK(result.deviation_mm <= 0.01);
  CHECK(result.stops == 0);
  const Point2 centre{0.0, 4.0};
  double most = 0.0;
  for (const Point2& p : result.tool)
    if (p.x_mm > 0.0 && p.y_mm < 4.0) most = std::max(most, std::abs(distance(p, centre) - 4.0));
  CHECK(most <= 0.01);
}

TEST_CASE("A circle smaller than the tolerance is driven out and back, given or as samples") {
  CertifiedWork work;
  PlanOptions options;
  options.tolerance_mm = 0.02;
  GivenPath path;
  path.points = {{0.005, 0.0}};
  path.arc({}, 2.0 * std::numbers::pi, 8);
  path.points.back() = path.points.front();
  for (int samples = 0; samples < 2; ++samples) {
    const PlanResult result = planned(path, options, work);
    CHECK(result.continuous_s > 0.0);
    CHECK(result.deviation_mm <= options.tolerance_mm);
    path.given.clear();
  }
}

TEST_CASE("A method that drives the chords of a given arc reports how far they are off it") {
  GivenPath path;
  path.points = {{10.0, 0.0}};
  path.arc({}, 0.5 * std::numbers::pi, 6);
  const auto arm = make_scara(cobra600());
  PathInput input;
  input.points = path.points;
  input.given = path.given;
  input.origin = kGivenPart;
  PlanOptions options;
  options.method = Method::kConstant;
  const PlanResult result = plan(input, *arm, cobra600_limits(), options);
  REQUIRE(result.ok());
  const double sagitta = 10.0 * (1.0 - std::cos(std::numbers::pi / 24.0));
  CHECK(result.deviation_mm <= sagitta + 1e-5);
  CHECK(result.deviation_mm > 0.9 * sagitta);
}

TEST_CASE("A given curve whose points are not on it, or that has none, is refused by its number") {
  const auto arm = make_scara(cobra600());
  const GivenPath good = rounded_corner(4.0);
  const auto refusal = [&](auto&& change) {
    GivenPath path = good;
    change(path);
    PathInput input;
    input.points = path.points;
    input.given = path.given;
    input.origin = kGivenPart;
    const PlanResult result = plan(input, *arm, cobra600_limits());
    return result.fault && result.fault->reason == Reason::kOption ? std::string(result.fault->what) : "";
  };
  CHECK(refusal([](GivenPath&) {}).empty());
  CHECK(refusal([](GivenPath& p) { p.given[0].centre.x_mm += 1e-3; }) == "given curves");
  CHECK(refusal([](GivenPath& p) { p.given[0].last = p.points.size(); }) == "given curves");
  CHECK(refusal([](GivenPath& p) { p.given[0].first = p.given[0].last; }) == "given curves");
  CHECK(refusal([](GivenPath& p) { p.given.push_back(p.given[0]); }) == "given curves");
  CHECK(refusal([](GivenPath& p) { p.given[0].kind = GivenCurve::Kind::kBezier; }) == "given curves");
}
