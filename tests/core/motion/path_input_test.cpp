#include "core/motion/kinematics/path_input.h"

#include <catch2/catch.hpp>
#include <cmath>

using namespace firn;
using namespace firn::motion;

namespace {

Reason refusal(const PathInput& input) {
  try {
    clean(input);
  } catch (const MotionError& e) {
    return e.fault().reason;
  }
  FAIL("accepted");
  return Reason::kNoSolution;
}

}  // namespace

TEST_CASE("A path is placed at its origin and a closed one returns to its first point") {
  const std::vector<Point2> square{{0, 0}, {1, 0}, {1, 1}};
  PathInput in{.points = square};
  in.origin = {10, 20};
  CHECK(clean(in).points.size() == 3);
  in.closed = true;
  const CleanPath path = clean(in);
  REQUIRE(path.points.size() == 4);
  CHECK(path.points.back() == Point2{10, 20});
  CHECK(path.source.back() == 0);
}

TEST_CASE("Repeated points are dropped and the lower of their speed limits stays") {
  const std::vector<Point2> points{{0, 0}, {0, 0}, {1, 0}, {1, 0}, {1, 1e-12}, {2, 0}};
  PathInput in{.points = points};
  in.speed_limit.point_mm_s = {50, 40, 100, 30, 60, 80};
  in.speed_limit.path_mm_s = 70;
  const CleanPath path = clean(in);
  REQUIRE(path.points.size() == 3);
  CHECK(path.speed_limit_mm_s == std::vector<double>{30, 30});
  CHECK(path.source == std::vector<std::size_t>{0, 2, 5});
}

TEST_CASE("Paths that cannot be planned are refused with a named reason") {
  const std::vector<Point2> one{{1, 2}}, same{{1, 2}, {1, 2}, {1, 2}}, line{{0, 0}, {1, 0}};
  const std::vector<Point2> hole{{0, 0}, {NAN, 0}, {1, 1}}, far{{0, 0}, {0, INFINITY}};
  CHECK(refusal({}) == Reason::kTooFewPoints);
  CHECK(refusal({.points = one}) == Reason::kTooFewPoints);
  CHECK(refusal({.points = same}) == Reason::kTooFewPoints);
  CHECK(refusal({.points = hole}) == Reason::kNotFinite);
  CHECK(refusal({.points = far}) == Reason::kNotFinite);
  PathInput in{.points = line};
  in.speed_limit.path_mm_s = 0;
  CHECK(refusal(in) == Reason::kSpeedLimitNotPositive);
  in.speed_limit.path_mm_s = 10;
  in.speed_limit.point_mm_s = {10};
  CHECK(refusal(in) == Reason::kSpeedLimitSize);
  in.speed_limit.point_mm_s = {10, NAN};
  CHECK(refusal(in) == Reason::kSpeedLimitNotPositive);
  in = {.points = line};
  in.yaw_rad = NAN;
  CHECK(refusal(in) == Reason::kNotFinite);
}
