#include "core/path/polyline.h"

#include <catch2/catch.hpp>
#include <vector>

using namespace firn;

TEST_CASE("The length of a closed polyline has the step back to the first point, if there are two") {
  const std::vector<Point2> corner{{0, 0}, {3, 0}, {3, 4}};
  CHECK(path_length_mm(corner, false) == 7.0);
  CHECK(path_length_mm(corner, true) == 12.0);
  CHECK(path_length_mm(std::vector<Point2>{{1, 1}}, true) == 0.0);
  CHECK(path_length_mm({}, true) == 0.0);
}

TEST_CASE("A segment is nearest beside a point or at an end, and without length at its place") {
  const Point2 a{1, 1}, b{5, 1};
  CHECK(nearest_share({2, 4}, a, b) == 0.25);
  CHECK(offset_from({2, 4}, a, b) == Point2{0, 3});
  CHECK(squared_distance({2, 4}, a, b) == 9.0);
  CHECK(squared_distance({-2, 5}, a, b) == 25.0);
  CHECK(squared_distance({8, -3}, a, b) == 25.0);
  CHECK(squared_distance({4, 5}, a, a) == 25.0);
}
