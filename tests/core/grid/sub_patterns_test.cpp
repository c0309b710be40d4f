#include "core/grid/sub_patterns.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

namespace firn {
namespace {

// Closed form: the smaller pitch; the diagonal or two cells on; two cells on.
double min_distance_mm(const GridSpec& g, int count) {
  const double x = g.pitch_x_mm, y = g.pitch_y_mm, two_on = 2.0 * std::min(x, y);
  if (count == 1) return std::min(x, y);
  return count == 2 ? std::min(std::hypot(x, y), two_on) : two_on;
}

TEST_CASE(
    "V-D.2: within a sub-pattern no two cells are nearer than its least distance, and some are as near") {
  const GridSpec grids[] = {
      {9, 8, 0.25, 0.25, 0.0, 0.0}, {7, 11, 0.2, 0.3, 1.0, -2.0}, {10, 6, 0.5, 0.1, 0.0, 0.0}};
  for (const GridSpec& g : grids)
    for (const int count : {1, 2, 4}) {
      CAPTURE(g.nx, count);
      double least = 1e9;
      for (int a = 0; a < int(g.size()); ++a)
        for (int b = 0; b < a; ++b) {
          const int ia = a % g.nx, ja = a / g.nx, ib = b % g.nx, jb = b / g.nx;
          if (sub_pattern_of(ia, ja, count) != sub_pattern_of(ib, jb, count)) continue;
          least = std::min(least, std::hypot(g.x_mm(ia) - g.x_mm(ib), g.y_mm(ja) - g.y_mm(jb)));
        }
      CHECK(least == Approx(min_distance_mm(g, count)).epsilon(1e-12));
    }
}

TEST_CASE("four sub-patterns keep droplets of Lu's diameter apart, two do not") {
  const GridSpec lu{40, 40, 0.263256, 0.263256, 0.0, 0.0};
  const double diameter_mm = 0.42;  // Table I
  CHECK(min_distance_mm(lu, 4) > diameter_mm);
  CHECK(min_distance_mm(lu, 2) < diameter_mm);
}

TEST_CASE("every cell belongs to one sub-pattern, and each has its share of cells") {
  for (const int count : {1, 2, 4}) {
    int cells[4] = {};
    for (int j = 0; j < 10; ++j)
      for (int i = 0; i < 12; ++i) {
        const int s = sub_pattern_of(i, j, count);
        REQUIRE(s >= 0);
        REQUIRE(s < count);
        ++cells[s];
      }
    for (int s = 0; s < count; ++s) CHECK(cells[s] == 120 / count);
  }
}

}  // namespace
}  // namespace firn
