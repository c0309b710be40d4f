// Arcs and Bezier curves that a file gives as such are the curve that is driven, not its samples.
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
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

Point2 in_base(Point2 p) { return {p.x_mm + kGivenPart.x_mm, p.y_mm + kGivenPart.y_mm}; }

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
    const Curve& curve = work.segments[0].curve;
    double at_knots = 0.0, between = 0.0;
    for (std::size_t i = 0; i < work.curve.coarse.s.size(); ++i)
      at_knots =
          std::max(at_knots,
                   std::abs(distance({work.curve.coarse.x[i], work.curve.coarse.y[i]}, kGivenPart) - radius));
    for (std::size_t i = 0; i < curve.cells(); ++i)
      between = std::max(
          between, std::abs(distance(curve.at(i, 0.5 * (curve.s[i] + curve.s[i + 1])), kGivenPart) - radius));
    INFO("radius " << radius);
    CHECK(at_knots < 1e-9);
    CHECK(between < 1e-6);
    CHECK(result.deviation_mm < 2e-5);
  }
}

TEST_CASE(
    "Without a tolerance a given arc leaves its circle only in the ramps at its ends, and no line moves") {
  CertifiedWork work;
  const double radius = 4.0;
  const GivenPath path = rounded_corner(radius);
  planned(path, {}, work);
  const Curve& curve = work.segments[0].curve;
  const Point2 centre = in_base({0.0, radius});
  constexpr double kBeyond_mm = 0.45;  // a ramp reaches over 0.4 mm on either side of its joint
  const double joint = 30.0, end = joint + 0.5 * std::numbers::pi * radius;
  double off_arc = 0.0, off_line = 0.0, most = 0.0;
  for (std::size_t i = 0; i < curve.cells(); ++i) {
    const double s = 0.5 * (curve.s[i] + curve.s[i + 1]);
    const Point2 p = curve.at(i, s);
    const double radial = std::abs(distance(p, centre) - radius);
    if (s < joint - kBeyond_mm) off_line = std::max(off_line, std::abs(p.y_mm - kGivenPart.y_mm));
    if (s > joint + kBeyond_mm && s < end - kBeyond_mm) off_arc = std::max(off_arc, radial);
    if (s > joint && s < end) most = std::max(most, radial);
  }
  CHECK(off_line < 1e-6);
  CHECK(off_arc < 2e-6);
  CHECK(most < 0.4 * 0.4 / (24.0 * radius));
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
