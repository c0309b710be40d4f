#include "core/path/followed_path.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "core/grid/random.h"

using namespace firn;

namespace {

using Place = std::function<Point2(double)>;

std::vector<Point2> sampled(const Place& place, double period_s, double end_s) {
  std::vector<Point2> points;
  for (int k = 0; k * period_s <= end_s; ++k) points.push_back(place(k * period_s));
  return points;
}

/// Knots of a curve, which is cubic between them, so that dense ones are the curve itself.
TimedPath path_of(const Place& place, double end_s, double pitch_s) {
  constexpr double kStep = 1e-5;
  std::vector<PathKnot> knots;
  for (double t = 0.0; t <= end_s + 1e-9; t += pitch_s) {
    const Point2 a = place(t - kStep), b = place(t + kStep), p = place(t);
    knots.push_back({t, p.x_mm, p.y_mm, (b.x_mm - a.x_mm) / (2 * kStep), (b.y_mm - a.y_mm) / (2 * kStep)});
  }
  return TimedPath(std::move(knots));
}

Place circle(double radius_mm, double speed_mm_s) {
  return [=](double t) {
    const double angle = speed_mm_s / radius_mm * t;
    return Point2{radius_mm * std::cos(angle), radius_mm * std::sin(angle)};
  };
}

/// At 5 mm/s along x from the origin.
Point2 straight(double t) { return {5.0 * t, 0.0}; }

}  // namespace

TEST_CASE("A path that is followed exactly has no contour error, no lag and its switches in place",
          "[followed]") {
  const TimedPath plan = path_of(circle(2.0, 5.0), 2.0, 0.01);
  const auto followed = sampled(circle(2.0, 5.0), 0.01, 2.0);
  const PathErrors e = path_errors(plan, 0.01, followed, std::vector<double>{1.0, 4.0, 9.0});
  CHECK(e.samples == followed.size());
  CHECK(e.contour_max_mm < 1e-4);
  CHECK(e.following_max_mm < 1e-5);
  CHECK(std::abs(e.lag_max_s) < 1e-5);
  CHECK(e.switch_max_mm < 1e-3);
}

TEST_CASE("A smaller circle, followed late, has the difference of the radii as contour error and its own lag",
          "[followed]") {
  const double radius = 2.0, speed = 5.0, cut = 0.03, late = 0.02;
  const TimedPath plan = path_of(circle(radius, speed), 2.0, 0.01);
  const auto inside = [&](double t) {
    const Point2 p = circle(radius, speed)(t - late);
    return Point2{p.x_mm * (radius - cut) / radius, p.y_mm * (radius - cut) / radius};
  };
  std::vector<Point2> followed = sampled(inside, 0.005, 1.9);
  const PathErrors e = path_errors(plan, 0.005, followed, {});
  // The first samples lie before the path's beginning, where its end is the nearest point.
  CHECK(e.contour_rms_mm == Approx(cut).epsilon(0.05));
  const double angle = speed * late / radius, chord2 = radius * radius + (radius - cut) * (radius - cut) -
                                                       2 * radius * (radius - cut) * std::cos(angle);
  CHECK(e.following_max_mm == Approx(std::sqrt(chord2)).epsilon(1e-3));
  CHECK(e.lag_max_s == Approx((radius - cut) * std::sin(angle) / speed).epsilon(1e-3));
  CHECK(std::isnan(e.switch_max_mm));
}

TEST_CASE("The distance of a sample is that of a search over the plan of its last second, for random paths",
          "[followed][seeded]") {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    CAPTURE(seed);
    RandomStream r(seed, Purpose::kTest);
    const double a = r.uniform(0.5, 3.0), b = r.uniform(0.5, 3.0), fx = r.uniform(0.5, 2.0),
                 fy = r.uniform(0.5, 2.0), shift = r.uniform(0.0, 0.01), off = r.uniform(0.0, 0.05);
    const auto wave = [=](double t) { return Point2{a * std::sin(fx * t), b * std::cos(fy * t)}; };
    const TimedPath plan = path_of(wave, 0.9, 0.02);
    const auto moved = [=](double t) {
      const Point2 p = wave(t - shift);
      return Point2{p.x_mm + off * std::sin(9.0 * t), p.y_mm - off * std::cos(7.0 * t)};
    };
    const auto followed = sampled(moved, 0.01, 0.85);
    const auto errors = contour_errors_mm(plan, 0.01, followed);
    // The plan's points are a millisecond apart, so the window's end is between these two.
    const auto nearest = [&](std::size_t k, double end_s) {
      double least = 1e9;
      for (double t = 0.0; t <= std::min(0.9, end_s); t += 5e-5) {
        const PathKnot p = plan.at(t);
        least = std::min(least, std::hypot(p.x_mm - followed[k].x_mm, p.y_mm - followed[k].y_mm));
      }
      return least;
    };
    double worst = 0.0;
    for (std::size_t k = 0; k < followed.size(); ++k) {
      const double t = 0.01 * double(k);
      worst = std::max({worst, errors[k] - nearest(k, t + 0.019), nearest(k, t + 0.023) - errors[k]});
    }
    CHECK(worst < 1e-3);
  }
}

TEST_CASE("A detour before a switch brings it too early by the detour's length", "[followed]") {
  const TimedPath plan = path_of(straight, 2.0, 0.1);
  const double detour = 0.04;
  const auto jump = [&](double t) {
    // One bump beside the path, as long as two legs of its height, between 0.5 and 0.6 s.
    const double u = std::clamp((t - 0.5) / 0.1, 0.0, 1.0),
                 up = 0.5 * (1.0 - std::cos(2 * std::numbers::pi * u));
    return Point2{5.0 * t, 0.2 * up};
  };
  const auto followed = sampled(jump, 0.005, 2.0);
  double extra = 0.0;
  for (double t = 0.5; t < 0.6; t += 1e-5) {
    const Point2 p = jump(t), q = jump(t + 1e-5);
    extra += std::hypot(q.x_mm - p.x_mm, q.y_mm - p.y_mm) - 5.0 * 1e-5;
  }
  REQUIRE(extra > detour);
  const PathErrors e = path_errors(plan, 0.005, followed, std::vector<double>{1.0, 8.0});
  CHECK(e.switch_max_mm == Approx(extra).epsilon(0.02));
  CHECK(e.worst_switch == 1);
  CHECK(e.contour_max_mm == Approx(0.2).epsilon(0.01));
  CHECK(e.worst_s == Approx(0.55).margin(0.006));
}

TEST_CASE("A switch where the plan stands is as far off as the place, in any direction", "[followed]") {
  const Place from_rest = [](double t) { return Point2{5.0 * t * t, 0.0}; };
  const TimedPath plan = path_of(from_rest, 1.0, 0.01);
  const double off_mm = 0.03, angle = GENERATE(0.0, 1.0, 2.0, 4.0);
  const auto beside = [&](double t) {
    const Point2 p = from_rest(t);
    return Point2{p.x_mm + off_mm * std::cos(angle), p.y_mm + off_mm * std::sin(angle)};
  };
  const PathErrors e = path_errors(plan, 0.01, sampled(beside, 0.01, 1.0), std::vector<double>{0.0});
  CHECK(e.switch_max_mm == Approx(off_mm));
  CHECK(e.worst_switch == 0);
}

TEST_CASE("An axis that stands for a while stalls by its way of that time, whatever the usual lag",
          "[followed]") {
  const double usual = GENERATE(0.0, 0.004, 0.03);
  const TimedPath plan = path_of(straight, 2.0, 0.1);
  const auto stands = [&](double t) {
    const double behind = std::max(0.0, t - usual);
    return straight(behind < 1.0 ? behind : behind < 1.06 ? 1.0 : behind < 1.2 ? behind - 0.06 : behind);
  };
  const auto followed = sampled(stands, 0.01, 1.9);
  const PathErrors e = path_errors(plan, 0.01, followed, {});
  CHECK(e.stall_max_mm == Approx(5.0 * 0.06).margin(0.06));
  CHECK(e.contour_max_mm < 1e-6);  // it never leaves the line
  CHECK(e.following_max_mm == Approx(5.0 * (0.06 + usual)).margin(0.06));
}

TEST_CASE("A path that was cut off is judged by what it has, and one without samples not at all",
          "[followed]") {
  const TimedPath plan = path_of(straight, 2.0, 0.1);
  const PathErrors cut = path_errors(plan, 0.01, sampled(straight, 0.01, 0.5), std::vector<double>{1.0, 9.0});
  CHECK(cut.contour_max_mm < 1e-6);
  CHECK(cut.switch_max_mm < 1e-6);
  const PathErrors none = path_errors(plan, 0.0, {}, std::vector<double>{1.0});
  CHECK(none.samples == 0);
  CHECK(std::isnan(none.contour_max_mm));
}

TEST_CASE("Middles by the followed path are read where it passes a station in the line's direction",
          "[followed]") {
  const auto beside = [](double t) { return Point2{5.0 * t, 0.02}; };
  const auto followed = sampled(beside, 0.01, 2.0);
  LineStation at;
  at.at = {3.013, 0.0};
  at.direction = {1.0, 0.0};
  LineStation against = at;
  against.direction = {-1.0, 0.0};
  CHECK(station_offset_rms_mm(followed, std::vector{at}) == Approx(0.02));
  CHECK(std::isnan(station_offset_rms_mm(followed, std::vector{against})));
}
