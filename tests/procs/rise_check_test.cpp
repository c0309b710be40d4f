#include "procs/scheduler/rise_check.h"

#include <catch2/catch.hpp>

#include <cstdlib>
#include <string>

namespace firn {
namespace {

/// A wall of 16 x 16 cells on bare ground, all of one height.
struct Wall {
  Experiment e;
  HeightMap before;
  DropletPattern rim, all;
  explicit Wall(double height_mm) {
    e.grid = {24, 24, 0.263256, 0.263256, 0.0, 0.0};
    before = HeightMap(e.grid, 0.0);
    rim = all = DropletPattern(e.grid, 0);
    for (int j = 4; j < 20; ++j)
      for (int i = 4; i < 20; ++i) {
        before.at(i, j) = float(height_mm);
        all.at(i, j) = 1;
        rim.at(i, j) = i == 4 || i == 19 || j == 4 || j == 19;
      }
  }
  std::string judged(const DropletPattern& drops, double rise_mm) const {
    HeightMap after = before;
    for (std::size_t n = 0; n < after.size(); ++n)
      if (drops.cells[n]) after.cells[n] += float(rise_mm);
    return check_rise(e, before, after, drops, {});
  }
};

}  // namespace

TEST_CASE("Droplets on a rim whose ink runs off are no dead nozzle's, a rim that does not rise at all is") {
  const Wall wall(0.4);
  CHECK(wall.judged(wall.rim, 0.0011) == "");
  CHECK(wall.judged(wall.rim, 0.0044) == "");
  CHECK_THAT(wall.judged(wall.rim, 0.0), Catch::Contains("drops without rise"));
  CHECK_THAT(wall.judged(wall.rim, 0.0001), Catch::Contains("drops without rise"));
}

TEST_CASE("Inside a wall and on bare ground a layer is to rise by its share") {
  const Wall wall(0.4), bare(0.0);
  CHECK(wall.judged(wall.all, 0.0076) == "");
  CHECK_THAT(wall.judged(wall.all, 0.0011), Catch::Contains("drops without rise"));
  CHECK(bare.judged(bare.rim, 0.0044) == "");
  CHECK_THAT(bare.judged(bare.rim, 0.0011), Catch::Contains("drops without rise"));
}

}  // namespace firn
