#include "estimators/droplet/layer_drops.h"

#include <catch2/catch.hpp>

using namespace firn;
using namespace firn::droplet;

TEST_CASE(
    "Several passes are several steps of (4), and a count of the jet below the stage's scales the droplets") {
  LayerDrops drops;
  PassReport r{DropletPattern(GridSpec{4, 3, 0.25, 0.25, 0.0, 0.0}, 1), 0, 2, 11, 12, 12};
  drops.add(r);
  CHECK_FALSE(drops.complete());
  r.pass = 1;
  r.triggered_jet = -1;
  r.commanded.cells[0] = 0;
  r.unknown_from = r.unknown_to = 11;
  drops.add(r);
  CHECK(drops.complete());
  REQUIRE(drops.passes().size() == 2);
  CHECK(drops.passes()[0].share == Approx(11.0 / 12.0));
  CHECK(drops.passes()[1].share == 1.0);
  CHECK(drops.passes()[1].cells.size() == 11);
}

TEST_CASE("Droplets in doubt are not taken as fired, and the cells about them teach nothing") {
  LayerDrops drops;
  const GridSpec g{6, 4, 0.25, 0.25, 0.0, 0.0};
  PassReport r{DropletPattern(g), 0, 1, -1, 2, 3};
  for (int i = 0; i < 6; ++i) r.commanded.at(i, 0) = 1;  // row 0 is fired from left to right
  drops.add(r);
  CHECK(drops.complete());
  REQUIRE(drops.passes().size() == 1);
  CHECK(drops.passes()[0].cells == std::vector<std::uint32_t>{0, 1});
  std::vector<std::int8_t> quality(24, 0);
  quality[g.index(5, 3)] = 1;
  Mask mask(g, 1);
  mask.at(0, 3) = 0;
  const auto use = drops.use_of(HeightMap(g, 0.0), quality, mask);
  for (int j = 0; j < 4; ++j)
    for (int i = 0; i < 6; ++i) {
      const Use expected = i == 5 && j == 3                                     ? Use::kNothing
                           : (i >= 1 && i <= 3 && j <= 1) || (i == 0 && j == 3) ? Use::kAnchor
                                                                                : Use::kLearn;
      CHECK(use[g.index(i, j)] == expected);
    }
}
