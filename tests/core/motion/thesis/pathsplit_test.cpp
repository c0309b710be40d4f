#include "core/motion/thesis/pathsplit.h"

#include <catch2/catch.hpp>

#include "core/grid/random.h"
#include "core/motion/thesis/test_path.h"

using namespace firn;
using namespace firn::motion;
using namespace firn::motion::thesis;

namespace {

CleanPath cleaned(const std::vector<Point2>& points, double speed_limit = kUnlimited) {
  PathInput in{.points = points};
  in.speed_limit.path_mm_s = speed_limit;
  return clean(in);
}

}  // namespace

TEST_CASE("4.2.2: the path of Fig. 4-2 is split into two pieces at the 90 degree corner") {
  const auto pieces = pathsplit(cleaned(thesis::fig_4_2()), {});
  REQUIRE(pieces.size() == 2);
  CHECK(distance(pieces[0].points.back(), {0, 0}) < 1e-9);
  CHECK(distance(pieces[1].points.front(), {0, 0}) < 1e-9);
  CHECK(pieces[0].s_mm.back() == Approx(306.97787143782136).epsilon(2e-5));
  CHECK(pieces[1].s_mm.back() == Approx(46.0));
}

TEST_CASE("Erratum, text of 4.3 and 4.4: the placed paths are Fig. 4-3's, the test path is Fig. 4-2's") {
  const auto path = thesis::fig_4_2();
  double far = 0, length = 0;
  for (std::size_t i = 0; i < path.size(); ++i) {
    far = std::max(far, distance({}, {path[i].x_mm + thesis::kPoorlyPlaced.x_mm,
                                      path[i].y_mm + thesis::kPoorlyPlaced.y_mm}));
    if (i > 0) length += distance(path[i - 1], path[i]);
  }
  CHECK(far == Approx(599.0).margin(1e-3));  // "within 1 mm of the robot maximum reach"
  CHECK(length == Approx(352.97787).margin(5e-3));
}

TEST_CASE("Turns below the split angle stay in one piece, turns above it part the path") {
  for (const double degrees : {5.0, 29.0, 31.0, 90.0, 179.0}) {
    const double angle = degrees * std::numbers::pi / 180;
    const std::vector<Point2> bend{{0, 0}, {10, 0}, {10 + 10 * std::cos(angle), 10 * std::sin(angle)}};
    CHECK(split_points(bend, std::numbers::pi / 6).size() == (degrees > 30.0 ? 3u : 2u));
  }
  const std::vector<Point2> cusp{{0, 0}, {10, 0}, {0, 0}};
  CHECK(split_points(cusp, std::numbers::pi / 6).size() == 3);
}

TEST_CASE("Points are redistributed evenly on the polyline, both ends kept") {
  RandomStream random(11, Purpose::kTest);
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<Point2> points{{0, 0}};
    for (int i = 0; i < 30; ++i)
      points.push_back(
          {points.back().x_mm + random.uniform(0.01, 3), points.back().y_mm + random.uniform(-0.1, 0.1)});
    const CleanPath path = cleaned(points);
    const thesis::Profile even = redistribute(path, 0, path.points.size() - 1, {});
    const double step = even.s_mm.back() / double(even.size() - 1);
    REQUIRE(even.points.front() == points.front());
    REQUIRE(distance(even.points.back(), points.back()) < 1e-12);
    REQUIRE(std::abs(step - 0.4) < 0.4 / double(even.size()));
    for (std::size_t i = 0; i + 1 < even.size(); ++i) {
      REQUIRE(even.s_mm[i + 1] - even.s_mm[i] == Approx(step).epsilon(1e-9));
      REQUIRE(distance(even.points[i], even.points[i + 1]) <= step * (1 + 1e-12));
    }
  }
}

TEST_CASE("A short piece still has enough points for third differences") {
  CHECK(redistribute(cleaned({{0, 0}, {0.05, 0}}), 0, 1, {}).size() == kMinIntervals + 1);
}

TEST_CASE("An interval takes the lowest speed limit of the segments it touches") {
  const std::vector<Point2> points{{0, 0}, {1, 0}, {2, 0}, {3, 0}};
  PathInput in{.points = points};
  in.speed_limit.point_mm_s = {90, 50, 90, 90};
  const thesis::Profile even = redistribute(clean(in), 0, 3, {});
  for (std::size_t i = 0; i + 1 < even.size(); ++i)
    CHECK(even.speed_limit_mm_s[i] == (even.s_mm[i] < 2.0 - 1e-12 ? 50 : 90));
}

TEST_CASE("Smoothing shortens a noisy path and keeps its ends") {
  RandomStream random(12, Purpose::kTest);
  std::vector<Point2> points;
  for (int i = 0; i <= 100; ++i) points.push_back({0.4 * i, 0.02 * random.normal()});
  PathSplitOptions options;
  const thesis::Profile rough = redistribute(cleaned(points), 0, 100, options);
  options.smoothing_points = 9;
  const thesis::Profile smooth = redistribute(cleaned(points), 0, 100, options);
  CHECK(smooth.s_mm.back() < rough.s_mm.back());
  CHECK(smooth.points.front() == points.front());
  CHECK(distance(smooth.points.back(), points.back()) < 1e-12);
}

TEST_CASE("Split options outside their range are refused") {
  const CleanPath path = cleaned({{0, 0}, {1, 0}});
  for (const double bad : {0.0, -1.0, 4.0, double(NAN)})
    CHECK_THROWS_AS(pathsplit(path, {.split_angle_rad = bad}), MotionError);
  for (const double bad : {0.0, -1.0, double(NAN), double(INFINITY)})
    CHECK_THROWS_AS(pathsplit(path, {.spacing_mm = bad}), MotionError);
  for (const int bad : {-1, 3, 6}) CHECK_THROWS_AS(pathsplit(path, {.smoothing_points = bad}), MotionError);
}
