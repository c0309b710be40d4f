#include "core/control/halftone.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/grid/random.h"

using namespace firn;
using namespace firn::control;

TEST_CASE("Nearest: each cell rounds half up within 0..max_drops, and cells outside the mask stay empty") {
  const GridSpec g{7, 1};
  Grid<double> wanted(g), carry(g);
  wanted.cells = {-3.0, 0.49, 0.5, 1.49, 1.5, 9.0, 2.0};
  Mask mask(g, 1);
  mask.at(6, 0) = 0;
  CHECK(halftone(wanted, mask, 3, Rounding::kNearest, carry).cells ==
        std::vector<std::uint8_t>{0, 0, 1, 1, 2, 3, 0});
}

TEST_CASE("Diffusion keeps the volume that was wanted to within the last row's rest") {
  const GridSpec g{30, 25};
  RandomStream random(5, Purpose::kTest);
  for (int trial = 0; trial < 20; ++trial) {
    Grid<double> wanted(g), carry(g);
    double sum = 0.0;
    for (double& w : wanted.cells) {
      w = random.uniform(0.2, 1.8);
      sum += w;
    }
    const DropletPattern drops = halftone(wanted, Mask(g, 1), 4, Rounding::kDiffusion, carry);
    CHECK(std::abs(double(drops.total()) - sum) < 2.0);
  }
  Grid<double> third(g, 1.0 / 3.0), carry(g);
  CHECK(std::abs(double(halftone(third, Mask(g, 1), 1, Rounding::kDiffusion, carry).total()) - 250.0) < 2.0);
}

TEST_CASE("A cell that cannot take its share does not flood its neighbours") {
  const GridSpec g{9, 1};
  Grid<double> wanted(g, 1.0), carry(g);
  wanted.at(4, 0) = 50.0;
  const DropletPattern drops = halftone(wanted, Mask(g, 1), 2, Rounding::kDiffusion, carry);
  CHECK(drops.at(4, 0) == 2);
  CHECK(drops.total() <= 8 + 2 + 1);
}

TEST_CASE("Carry hands the rest of a cell to its next layer: 0.3 droplets a layer are 3 in 10") {
  const GridSpec g{2, 2};
  Grid<double> wanted(g, 0.3), carry(g);
  std::int64_t total = 0;
  for (int layer = 0; layer < 10; ++layer)
    total += halftone(wanted, Mask(g, 1), 2, Rounding::kCarry, carry).total();
  CHECK(total == 12);
}
