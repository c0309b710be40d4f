#include "core/statistics/space_filling.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <set>
#include <utility>

using namespace firn::statistics;

namespace {

// Points of a design in each box of a grid that divides two axes.
bool one_in_each_box(const Design& d, int points, int axis_a, int boxes_a, int axis_b, int boxes_b) {
  std::set<std::pair<int, int>> taken;
  for (int n = 0; n < points; ++n)
    if (!taken.emplace(int(d.at(n, axis_a) * boxes_a), int(d.at(n, axis_b) * boxes_b)).second) return false;
  return int(taken.size()) == boxes_a * boxes_b;
}

}  // namespace

TEST_CASE("Each interval of each axis holds one point of a Latin hypercube, whatever the seed") {
  for (std::uint64_t seed = 1; seed <= 20; ++seed)
    for (const int points : {1, 2, 7, 64, 1000}) {
      const Design d = latin_hypercube(points, kMaxDesignAxes, seed);
      INFO(points << " points, seed " << seed);
      for (int axis = 0; axis < kMaxDesignAxes; ++axis)
        CHECK(one_in_each_box(d, points, axis, points, axis == 0 ? 1 : 0, 1));
    }
}

TEST_CASE("Of 2^k Sobol points each of 2^k intervals of every axis holds one") {
  for (std::uint64_t seed = 1; seed <= 20; ++seed)
    for (const int points : {1, 2, 16, 256}) {
      const Design d = sobol(points, kMaxDesignAxes, seed);
      INFO(points << " points, seed " << seed);
      for (int axis = 0; axis < kMaxDesignAxes; ++axis)
        CHECK(one_in_each_box(d, points, axis, points, axis == 0 ? 1 : 0, 1));
    }
}

TEST_CASE("The first two axes of Sobol's sequence fill every dyadic box of 256 points") {
  // A (0, m, 2)-net: the sequence of these two axes has the quality parameter 0.
  const Design d = sobol(256, 2, 5);
  for (int boxes = 1; boxes <= 256; boxes *= 2) CHECK(one_in_each_box(d, 256, 0, boxes, 1, 256 / boxes));
}

TEST_CASE("The mean of a product over 4,096 Sobol points is within 1e-3, ten times nearer than by chance") {
  const Design d = sobol(4096, kMaxDesignAxes, 3);
  double sum = 0.0;
  for (int n = 0; n < 4096; ++n) {
    double product = 1.0;
    for (int axis = 0; axis < kMaxDesignAxes; ++axis) product *= 2.0 * d.at(n, axis);
    sum += product;
  }
  CHECK(std::abs(sum / 4096 - 1.0) <
        1e-3);  // one point of it has the standard deviation (4/3)^3 - 1, root: 1.17
}

TEST_CASE("The same seed gives the same design and another seed another one") {
  for (const auto make : {&latin_hypercube, &sobol}) {
    CHECK(make(50, 3, 7).values == make(50, 3, 7).values);
    CHECK(make(50, 3, 7).values != make(50, 3, 8).values);
  }
  CHECK_THROWS_WITH(sobol(10, 7, 1), Catch::Contains("not 1 to 6"));
  CHECK_THROWS_WITH(latin_hypercube(0, 2, 1), Catch::Contains("1 is the least"));
}
