// Without a tolerance the curve passes every point within its rounding, where that is asked for.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "core/motion/certified/certified.h"
#include "core/motion/planner.h"
#include "tests/core/motion/emitted_ratio.h"
#include "tests/core/motion/held_paths.h"
#include "tests/core/motion/random_paths.h"
#include "tests/core/motion/sampled_curves.h"

namespace firn::motion {
namespace {

constexpr Point2 kHeldPart{400.0, 0.0};
constexpr double kSampledChords_mm = 5e-6;  ///< sagitta of the chords between samples

PlanResult plan_held(const std::vector<Point2>& points, Point2 origin, PlanOptions options,
                     CertifiedWork& work) {
  static const auto arm = make_scara(cobra600());
  PathInput input;
  input.points = points;
  input.origin = origin;
  options.point_rule = PointRule::kHeld;
  return plan_certified(input, *arm, cobra600_limits(), options, work);
}

HeldDistances found_distances(const std::vector<Point2>& points, Point2 origin, const PlanResult& result,
                              const CertifiedWork& work) {
  std::vector<Point2> in_base;
  for (const Point2& p : points) in_base.push_back({p.x_mm + origin.x_mm, p.y_mm + origin.y_mm});
  return sampled_distances(in_base, work.segments(), result.stops + 1, result.points_off_mm);
}

PlanOptions held_to(int decimals) {
  PlanOptions options;
  options.point_noise_mm = decimals < 9 ? 0.5 * std::pow(10.0, -decimals) : 0.0;
  return options;
}

}  // namespace

TEST_CASE("A line into dense samples and slight corners of a polygon are passed within 0.2 um, where asked") {
  std::vector<Point2> samples{{0.0, 0.0}, {10.0, 0.0}};
  for (int k = 1; k < 100; ++k) samples.push_back({10.0 + 0.05 * k, 2.5e-5 * k * k});
  const std::vector<Point2> corners{{0.0, 0.0}, {10.0, 0.0}, {20.0, 0.5}, {30.0, 0.5}};
  CertifiedWork work;
  for (const auto& points : {samples, corners}) {
    const PlanResult result = plan_held(points, kHeldPart, {}, work);
    CHECK(result.stops == 0);
    CHECK(result.held_mm == PlanOptions::kMinHold_mm);
    CHECK(result.points_off_mm <= result.held_mm);
    const HeldDistances found = found_distances(points, kHeldPart, result, work);
    CHECK(found.points_mm <= result.points_off_mm + kSampledChords_mm);
    CHECK(found.curve_mm <= result.deviation_mm + kSampledChords_mm);
    CHECK(result.deviation_mm < 4e-4);  // the line and the corners' chords are followed, too
  }
}

TEST_CASE("Held points of 40 random paths are passed within their rounding, as told, and within all limits") {
  HeldPathMaker maker(7);
  CertifiedWork work;
  for (int k = 0; k < 40; ++k) {
    const HeldPath path = maker.next();
    const PlanResult result = plan_held(path.points, kHeldPart, held_to(path.decimals), work);
    INFO("path " << k << ", " << path.kind << ", decimals " << path.decimals);
    CHECK(result.held_mm == Approx(path.decimals == 3 ? 7.0711e-4 : 2e-4));
    CHECK(result.points_off_mm <= result.held_mm);
    const HeldDistances found = found_distances(path.points, kHeldPart, result, work);
    CHECK(found.points_mm <= result.points_off_mm + kSampledChords_mm);
    CHECK(found.curve_mm <= result.deviation_mm + kSampledChords_mm);
    CHECK(emitted_ratio(result, work) <= 1.0);
  }
}

TEST_CASE("Rounding steps back beside five cusps: held points cost little more time than exact ones") {
  const auto epicycloid = [](double t) {
    const double w = 2.0 * std::numbers::pi * t;
    return Point2{24.0 * std::cos(w) - 4.0 * std::cos(6.0 * w), 24.0 * std::sin(w) - 4.0 * std::sin(6.0 * w)};
  };
  CertifiedWork work;
  for (const int samples : {2000, 8000}) {
    INFO(samples << " samples");
    double time_s[2];
    for (const int decimals : {9, 3}) {
      const std::vector<Point2> points = at_parameters(epicycloid, samples, decimals);
      const PlanResult result = plan_held(points, kHeldPart, held_to(decimals), work);
      CHECK(result.stops == 4);
      CHECK(result.points_off_mm <= result.held_mm);
      time_s[decimals == 3] = result.continuous_s;
    }
    CHECK(time_s[1] < 1.05 * time_s[0]);
  }
}

TEST_CASE("Rounded samples beside cusps of 24 epicycloids are driven about as fast as exact ones") {
  RandomStream draw(5, Purpose::kTest);
  CertifiedWork work;
  double sum_s[2] = {};
  for (int k = 0; k < 24; ++k) {
    const ParametricCurve curve = curves::epicycloid(draw);
    const int chords = int(500.0 * std::pow(16.0, draw.uniform(0.0, 1.0)));
    INFO("epicycloid " << k << ", " << chords << " chords");
    double time_s[2];
    for (const int decimals : {9, 3}) {
      const std::vector<Point2> points = at_parameters(curve, chords, decimals);
      const PlanResult result = plan_held(points, kHeldPart, held_to(decimals), work);
      CHECK(result.points_off_mm <= result.held_mm);
      CHECK(found_distances(points, kHeldPart, result, work).points_mm <=
            result.points_off_mm + kSampledChords_mm);
      time_s[decimals == 3] = result.continuous_s;
      sum_s[decimals == 3] += result.continuous_s;
    }
    CHECK(time_s[1] < 1.2 * time_s[0]);
  }
  CHECK(sum_s[1] < 1.04 * sum_s[0]);
}

TEST_CASE("Samples some roundings apart are driven as fast as those far apart, on lobes and on an outline") {
  CertifiedWork work;
  const auto time_s = [&](int kind, std::uint64_t seed, double step_mm, int decimals) {
    const std::vector<Point2> points = sampled(random_curve(kind, seed), step_mm, decimals);
    const PlanResult result = plan_held(points, kHeldPart, held_to(decimals), work);
    CHECK(result.points_off_mm <= result.held_mm);
    CHECK(result.stops == 0);
    return result.continuous_s;
  };
  CHECK(time_s(0, 90003, 0.01, 3) < 1.01 * time_s(0, 90003, 0.2, 9));
  CHECK(time_s(4, 72015, 0.02, 3) < 1.02 * time_s(4, 72015, 0.02, 9));
}

TEST_CASE("Cells too long for the joint of an outline's line and arc are halved: its samples are held") {
  CertifiedWork work;
  const auto time_s = [&](int decimals, Method method) {
    const std::vector<Point2> points = sampled(random_curve(4, 5), 0.037312, decimals);
    PlanOptions options = held_to(decimals);
    options.method = method;
    const PlanResult result = plan_held(points, kHeldPart, options, work);
    CHECK(result.points_off_mm <= result.held_mm);
    return result.continuous_s;
  };
  const double fast_s = time_s(3, Method::kCertified);
  CHECK(fast_s < 1.01 * time_s(9, Method::kCertified));
  CHECK(time_s(3, Method::kOptimal) < 1.001 * fast_s);
}

TEST_CASE("Samples as far apart as their chords stay near a curve are driven as fast as near ones") {
  CertifiedWork work;
  const auto time_s = [&](const std::vector<Point2>& points, int decimals) {
    const PlanResult result = plan_held(points, kHeldPart, held_to(decimals), work);
    CHECK(result.points_off_mm <= result.held_mm);
    CHECK(result.stops == 0);
    return result.continuous_s;
  };
  double near_sum_s = 0.0, far_sum_s = 0.0;
  for (const int kind : {0, 1, 2, 3, 4})
    for (const std::uint64_t seed : {7, 8, 9})
      for (const double sagitta_mm : {0.005, 0.02}) {
        INFO(kCurveKind[kind] << " " << seed << ", chords off by " << sagitta_mm);
        const ParametricCurve curve = random_curve(kind, seed);
        const double near_s = time_s(sampled(curve, 0.1, 9), 9),
                     far_s = time_s(within_sagitta(curve, sagitta_mm, 3), 3);
        CHECK(far_s < 1.1 * near_s);
        near_sum_s += near_s;
        far_sum_s += far_s;
      }
  CHECK(far_sum_s < 1.01 * near_sum_s);
}

TEST_CASE("Chords that turn by much are samples of a tight arc beside their like, else corners") {
  CertifiedWork work;
  const auto stops = [&](double turn_rad, int vertices, double chord_mm) {
    std::vector<Point2> points;
    Point2 p{0.0, 0.0};
    double heading = 0.0;
    const auto step = [&](double length) {
      points.push_back(p = {p.x_mm + length * std::cos(heading), p.y_mm + length * std::sin(heading)});
    };
    for (int i = 0; i < 10; ++i) step(0.3);
    for (int k = 0; k < vertices; ++k) {
      heading += (k == 0 || k + 1 == vertices ? 0.5 : 1.0) * turn_rad;
      step(chord_mm);
    }
    for (int i = 0; i < 10; ++i) step(0.3);
    return plan_held(points, kHeldPart, held_to(9), work).stops;
  };
  CHECK(stops(0.6, 6, 0.3) == 0);  // an arc of 0.5 mm, its chords off by 0.022 mm
  CHECK(stops(0.6, 6, 1.5) > 0);   // of 2.5 mm, off by 0.11 mm: a polygon
  CHECK(stops(2.4, 2, 0.3) > 0);   // two corners
}

TEST_CASE("Held points with cusps, spikes and steps of nanometres are passed within their rounding") {
  RandomPathMaker maker(8);
  CertifiedWork work;
  for (int k = 0; k < 20; ++k) {
    const RandomPath path = maker.next();
    const PlanResult result = plan_held(path.points, {}, {}, work);
    INFO("path " << k << ", " << path.kind);
    CHECK(result.points_off_mm <= result.held_mm);
    CHECK(found_distances(path.points, {}, result, work).points_mm <=
          result.points_off_mm + kSampledChords_mm);
    CHECK(emitted_ratio(result, work) <= 1.0);
  }
}

TEST_CASE("An ellipse whose points are held takes the same at any spacing and rounding") {
  CertifiedWork work;
  for (const auto& [step, decimals] : {std::pair{0.1, 9}, {0.3, 3}, {0.3, 9}, {1.0, 3}, {1.0, 9}}) {
    const auto ellipse = [](double t) {
      const double w = 2.0 * std::numbers::pi * t;
      return Point2{45.0 * std::cos(w), 30.0 * std::sin(w)};
    };
    const PlanResult result = plan_held(sampled(ellipse, step, decimals), kHeldPart, held_to(decimals), work);
    INFO("step " << step << ", decimals " << decimals);
    CHECK(result.points_off_mm <= result.held_mm);
    CHECK(result.continuous_s < 1.02 * 2.36);
  }
}

TEST_CASE("The slow tier holds points, too, and is not slower") {
  HeldPathMaker maker(9);
  CertifiedWork work;
  for (int k = 0; k < 3; ++k) {
    const HeldPath path = maker.next();
    PlanOptions options = held_to(path.decimals);
    const double fast = plan_held(path.points, kHeldPart, options, work).continuous_s;
    options.method = Method::kOptimal;
    const PlanResult result = plan_held(path.points, kHeldPart, options, work);
    INFO("path " << k << ", " << path.kind << ", decimals " << path.decimals);
    CHECK(result.points_off_mm <= result.held_mm);
    CHECK(found_distances(path.points, kHeldPart, result, work).points_mm <=
          result.points_off_mm + kSampledChords_mm);
    CHECK(result.continuous_s < 1.001 * fast);
  }
}

TEST_CASE("Beside held points given arcs stay within 0.12 um") {
  std::vector<Point2> points{{-30.0, 0.0}, {0.0, 0.0}};
  GivenCurve arc;
  arc.centre = {0.0, 10.0};
  arc.first = 1;
  constexpr int kSamples = 40;
  for (int i = 1; i <= kSamples; ++i) {
    const double at = 0.5 * std::numbers::pi * i / kSamples;
    points.push_back({10.0 * std::sin(at), 10.0 - 10.0 * std::cos(at)});
  }
  arc.last = points.size() - 1;
  for (int k = 1; k < 40; ++k) points.push_back({10.0 - 2.5e-5 * k * k, 10.0 + 0.05 * k});
  const std::vector<GivenCurve> given{arc};
  PathInput input;
  input.points = points;
  input.given = given;
  input.origin = kHeldPart;
  PlanOptions options;
  options.point_rule = PointRule::kHeld;
  CertifiedWork work;
  const PlanResult result = plan_certified(input, *make_scara(cobra600()), cobra600_limits(), options, work);
  CHECK(result.deviation_mm <= 1.2e-4);
  CHECK(result.points_off_mm <= result.held_mm);
}

TEST_CASE("An ellipse takes as long however its samples are spaced and rounded, without a tolerance too") {
  const auto arm = make_scara(cobra600());
  const double a = 45.0, b = 30.0;
  for (const double step_mm : {0.3, 1.0, 2.0})
    for (const int decimals : {3, 5, 9}) {
      const double unit = std::pow(10.0, -decimals);
      const int chords = int(std::round(237.98 / step_mm));
      std::vector<Point2> points;
      double angle = 0.0;
      for (int k = 0; k <= chords; ++k) {
        points.push_back(
            {unit * std::round(a * std::cos(angle) / unit), unit * std::round(b * std::sin(angle) / unit)});
        angle += 237.98 / chords / std::hypot(a * std::sin(angle), b * std::cos(angle));
      }
      PathInput input;
      input.points = points;
      input.origin = kHeldPart;
      PlanOptions options = held_to(decimals);
      options.point_rule = PointRule::kFaster;
      const PlanResult result = plan(input, *arm, cobra600_limits(), options);
      INFO(step_mm << " mm, " << decimals << " decimals");
      REQUIRE(result.ok());
      CHECK(std::abs(result.trajectory.certificate.duration_s - 2.368) < 1.5 * options.tick_s);
    }
}

TEST_CASE("Two tight turns leave the rest of an ellipse as smooth: held points at any spacing and rounding") {
  const auto ellipse = [](double t) {
    const double w = 2.0 * std::numbers::pi * t + 1.5;
    return Point2{40.0 * std::cos(w), 3.5 * std::sin(w)};
  };
  CertifiedWork work;
  for (const auto& [step, decimals] : {std::pair{0.05, 3}, {0.05, 4}, {0.1, 3}, {0.1, 9}}) {
    const PlanResult result = plan_held(sampled(ellipse, step, decimals), kHeldPart, held_to(decimals), work);
    INFO("step " << step << ", decimals " << decimals);
    CHECK(result.points_off_mm <= result.held_mm);
    CHECK(result.continuous_s < 1.01 * 2.19);
  }
}

TEST_CASE(
    "A step back by one unit of the last decimal costs nothing, one by more costs stops, not the path") {
  const auto circle = [](double t) {
    const double w = 2.0 * std::numbers::pi * t;
    return Point2{60.0 * std::cos(w), 60.0 * std::sin(w)};
  };
  CertifiedWork work;
  const std::vector<Point2> points = sampled(circle, 0.3, 3);
  const double plain = plan_held(points, kHeldPart, held_to(3), work).continuous_s;
  const auto with_step = [&](double x_mm, double y_mm) {
    std::vector<Point2> other = points;
    const std::size_t middle = points.size() / 2;  // where the circle goes towards -y
    const Point2 p = points[middle];
    other.insert(other.begin() + std::ptrdiff_t(middle) + 1, {p.x_mm + x_mm, p.y_mm + y_mm});
    const PlanResult result = plan_held(other, kHeldPart, held_to(3), work);
    CHECK(result.points_off_mm <= result.held_mm);
    CHECK(found_distances(other, kHeldPart, result, work).points_mm <=
          result.points_off_mm + kSampledChords_mm);
    return result.continuous_s;
  };
  CHECK(with_step(0.0, 0.001) < 1.005 * plain);
  CHECK(with_step(0.001, 0.0) < 1.005 * plain);
  CHECK(with_step(0.001, 0.001) < 1.2 * plain);
  CHECK(with_step(0.0, 0.002) < 1.2 * plain);
}

TEST_CASE("Long sample intervals beside short ones are no lines: a curve sampled at random is as fast") {
  const auto figure = [](double t) {
    const double w = 2.0 * std::numbers::pi * t;
    return Point2{35.0 * std::cos(3.0 * w), 30.0 * std::sin(2.0 * w)};
  };
  CertifiedWork work;
  const double even = plan_held(sampled(figure, 0.1, 9), kHeldPart, {}, work).continuous_s;
  for (const int decimals : {3, 5, 9})
    for (const std::uint64_t seed : {1, 2}) {
      RandomStream draw(seed, Purpose::kTest);
      std::vector<double> at{0.0, 1.0};
      for (int k = 0; k < 2500; ++k) at.push_back(draw.uniform(0.0, 1.0));
      std::sort(at.begin(), at.end());
      const double unit = std::pow(10.0, -decimals);
      std::vector<Point2> points;
      for (const double t : at) {
        const Point2 p = figure(t);
        points.push_back({unit * std::round(p.x_mm / unit), unit * std::round(p.y_mm / unit)});
      }
      const PlanResult result = plan_held(points, kHeldPart, held_to(decimals), work);
      INFO(decimals << " decimals, seed " << seed);
      CHECK(result.points_off_mm <= result.held_mm);
      CHECK(result.continuous_s < 1.2 * even);
    }
}

TEST_CASE("A curve bulges between samples far apart: it is as fast as through many of them") {
  const auto spiral = [](double t) {
    const double w = 8.0 * std::numbers::pi * t, r = 5.0 + 20.0 * t;
    return Point2{r * std::cos(w), r * std::sin(w)};
  };
  CertifiedWork work;
  const double even = plan_held(sampled(spiral, 0.2, 9), kHeldPart, {}, work).continuous_s;
  CHECK(plan_held(sampled(spiral, 1.5, 9), kHeldPart, {}, work).continuous_s < 1.01 * even);
  for (const std::uint64_t seed : {1, 2, 3}) {
    RandomStream draw(seed, Purpose::kTest);
    std::vector<double> at{0.0, 1.0};
    for (int k = 0; k < 1000; ++k) at.push_back(draw.uniform(0.0, 1.0));
    std::sort(at.begin(), at.end());
    std::vector<Point2> points;
    for (const double t : at) points.push_back(spiral(t));
    const PlanResult result = plan_held(points, kHeldPart, {}, work);
    INFO("seed " << seed);
    CHECK(result.points_off_mm <= result.held_mm);
    CHECK(result.deviation_mm <= 0.2);
    CHECK(result.continuous_s < 1.03 * even);
  }
}

TEST_CASE("Samples nearer to each other than some roundings have no corners by chance") {
  const auto spiral = [](double t) {
    const double w = 6.0 * std::numbers::pi * t, r = 5.0 + 20.0 * t;
    return Point2{r * std::cos(w), r * std::sin(w)};
  };
  CertifiedWork work;
  for (const std::uint64_t seed : {1, 2, 3, 4}) {
    RandomStream draw(seed, Purpose::kTest);
    std::vector<double> at{0.0, 1.0};
    for (int k = 0; k < 5000; ++k) at.push_back(draw.uniform(0.0, 1.0));
    std::sort(at.begin(), at.end());
    std::vector<Point2> points;
    for (const double t : at)
      points.push_back({1e-3 * std::round(1e3 * spiral(t).x_mm), 1e-3 * std::round(1e3 * spiral(t).y_mm)});
    INFO("seed " << seed);
    CHECK(plan_held(points, kHeldPart, held_to(3), work).stops == 0);
  }
}

TEST_CASE("Where a chord that is no line was held as one, the fit is repeated without") {
  const std::vector<Point2> points{{34.97772, 26.33023}, {34.98358, 26.28164}, {34.98401, 26.27779},
                                   {34.92921, 25.32145}, {34.65348, 24.46008}, {34.63797, 24.42385},
                                   {34.52296, 24.17359}};
  CertifiedWork work;
  const PlanResult result = plan_held(points, kHeldPart, held_to(5), work);
  CHECK(result.points_off_mm <= result.held_mm);
  CHECK(result.continuous_s < 0.5);
}

TEST_CASE("Without a tolerance a path is driven no slower than with held points, nor than with ramps") {
  const auto arm = make_scara(cobra600());
  HeldPathMaker maker(8100);
  for (int k = 0; k < 12; ++k) {
    const HeldPath path = maker.next();
    PathInput input;
    input.points = path.points;
    input.origin = kHeldPart;
    PlanOptions options = held_to(path.decimals);
    const auto seconds = [&](PointRule rule) {
      options.point_rule = rule;
      const PlanResult result = plan(input, *arm, cobra600_limits(), options);
      return result.ok() ? result.trajectory.certificate.duration_s : 1e9;
    };
    INFO(k << ": " << path.kind);
    CHECK(seconds(PointRule::kFaster) == std::min(seconds(PointRule::kRamped), seconds(PointRule::kHeld)));
  }
}

TEST_CASE("A tube too narrow for its turns costs that fit, not the path") {
  HeldPathMaker maker(5000);
  constexpr int kNarrow = 1881;  // a line of 12 mm turns by 21 degrees into samples 0.26 mm apart
  for (int k = 0; k < kNarrow; ++k) maker.next();
  const HeldPath path = maker.next();
  CertifiedWork work;
  PlanOptions options = held_to(path.decimals);
  for (const Method method : {Method::kCertified, Method::kOptimal}) {
    options.method = method;
    const PlanResult result = plan_held(path.points, kHeldPart, options, work);
    CHECK(result.points_off_mm <= result.held_mm);
  }
}

TEST_CASE("A corner whose point is held is a stop, or is passed within the rounding") {
  CertifiedWork work;
  for (const double turn : {0.3, 0.5, 0.55, 1.5, 3.0}) {
    const std::vector<Point2> points{
        {0.0, 0.0}, {20.0, 0.0}, {20.0 + 15.0 * std::cos(turn), 15.0 * std::sin(turn)}};
    const PlanResult result = plan_held(points, kHeldPart, held_to(3), work);
    INFO("turn " << turn);
    CHECK(result.stops == (turn > 0.53 ? 1 : 0));
    CHECK(result.deviation_mm <= result.held_mm);
  }
}

}  // namespace firn::motion
