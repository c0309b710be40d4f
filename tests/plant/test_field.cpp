#include <catch2/catch.hpp>

#include <cmath>
#include <cstring>

#include "core/grid/random.h"
#include "plant/inkjet/field.h"
#include "plant/inkjet/footprint.h"

using namespace firn;
using namespace firn::plant;

namespace {

GridSpec lu_grid(int side) { return {side, side, 0.263256, 0.263256, 0.0, 0.0}; }

double balance(const Field& f) {
  const VolumeLedger& l = f.ledger();
  return (l.landed - l.lost - l.shrunk - f.volume_mm3()) / l.landed;
}

bool in_disc(int i, int j, double centre, double radius) {
  return std::hypot(i - centre, j - centre) <= radius;
}

}  // namespace

TEST_CASE("A droplet on flat ground raises own, side and corner cells by Lu's 4.4, 0.6 and 0.2 um") {
  DropletParams p;
  RandomStream random(7, Purpose::kTest);
  double h1 = 0, h2 = 0, h3 = 0;
  const int droplets = 200;
  for (int n = 0; n < droplets; ++n) {
    Field f(lu_grid(9), p.fine_cells, p.margin_cells);
    REQUIRE(f.land(p, p.volume_mm3, 4 * 0.263256 + p.placement_scatter_mm * random.normal(),
                   4 * 0.263256 + p.placement_scatter_mm * random.normal()));
    f.cure(p.cure_shrink);
    const HeightMap m = f.cell_means();
    h1 += m.at(4, 4);
    h2 += (m.at(3, 4) + m.at(5, 4) + m.at(4, 3) + m.at(4, 5)) / 4;
    h3 += (m.at(3, 3) + m.at(5, 3) + m.at(3, 5) + m.at(5, 5)) / 4;
  }
  CHECK(h1 / droplets * 1e3 == Approx(4.4).margin(0.1));
  CHECK(h2 / droplets * 1e3 == Approx(0.6).margin(0.03));
  CHECK(h3 / droplets * 1e3 == Approx(0.2).margin(0.02));
}

TEST_CASE("Fired volume equals field volume plus lost plus shrunk, wherever droplets land") {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    DropletParams p;
    p.fine_cells = 2 + int(seed);
    RandomStream random(seed, Purpose::kTest);
    Field f(lu_grid(12), p.fine_cells, p.margin_cells);
    for (int layer = 0; layer < 6; ++layer) {
      for (int n = 0; n < 400; ++n)
        f.land(p, p.volume_mm3 * random.uniform(0.5, 1.5), random.uniform(-1.5, 4.5),
               random.uniform(-1.5, 4.5));
      CHECK(std::abs(balance(f)) < 1e-12);
      f.cure(p.cure_shrink);
    }
    CHECK(f.ledger().lost > 0.0);
    CHECK(std::abs(balance(f)) < 1e-12);
  }
}

TEST_CASE("A droplet far outside the field, or at no number, is lost and changes nothing") {
  DropletParams p;
  Field f(lu_grid(8), p.fine_cells, p.margin_cells);
  CHECK_FALSE(f.land(p, p.volume_mm3, 1e9, 0.0));
  CHECK_FALSE(f.land(p, p.volume_mm3, std::nan(""), 0.0));
  CHECK(f.volume_mm3() == 0.0);
  CHECK(f.ledger().lost == f.ledger().landed);
}

TEST_CASE("Liquid runs downhill: beside a step the low side gets more than the high side") {
  DropletParams p;
  Field f(lu_grid(9), p.fine_cells, p.margin_cells);
  for (int b = 0; b < f.height(); ++b)
    for (int a = 0; a < f.width() / 2; ++a) f.set_solid_mm(a, b, 0.02);
  const HeightMap before = f.cell_means();
  f.land(p, p.volume_mm3, 4 * 0.263256, 4 * 0.263256);
  const HeightMap after = f.cell_means();
  const double uphill = after.at(3, 4) - before.at(3, 4), downhill = after.at(5, 4) - before.at(5, 4);
  CHECK(downhill > 1.05 * uphill);
}

TEST_CASE("Ten open-loop layers of a disc make a dome: edges low, layer height 7.6 um inside") {
  DropletParams p;
  const int side = 24;
  const double centre = 11.5;
  Field f(lu_grid(side), p.fine_cells, p.margin_cells);
  for (int layer = 0; layer < 10; ++layer) {
    for (int j = 0; j < side; ++j)
      for (int i = 0; i < side; ++i)
        if (in_disc(i, j, centre, 9.0)) f.land(p, p.volume_mm3, i * 0.263256, j * 0.263256);
    f.cure(p.cure_shrink);
  }
  const HeightMap m = f.cell_means();
  CHECK(m.at(11, 11) * 1e3 == Approx(76.0).margin(1.0));
  CHECK(m.at(3, 11) < m.at(4, 11));  // the rim shrinks,
  CHECK(m.at(4, 11) < m.at(6, 11));  // gradually over several cells,
  CHECK(m.at(6, 11) < m.at(11, 11));
  CHECK(m.at(3, 11) < 0.9 * m.at(11, 11));
  CHECK(m.at(3, 11) ==
        Approx(m.at(20, 11)).epsilon(0.15));  // alike on all sides, but for the order of printing
  CHECK(m.at(3, 11) == Approx(m.at(11, 20)).epsilon(0.15));
}

TEST_CASE("The vectorised footprint gives the same bytes as the portable one") {
  RandomStream random(82, Purpose::kTest);
  for (int trial = 0; trial < 2000; ++trial) {
    // Any stride and start, so that rows begin at any alignment.
    const int nx = 1 + int(random.below(kMaxFootprint)), ny = 1 + int(random.below(kMaxFootprint));
    const int stride = nx + int(random.below(5)), start = int(random.below(4));
    std::vector<double> solid(std::size_t(start) + std::size_t(stride) * ny), wet(solid.size());
    for (auto& z : solid) z = random.uniform(0.0, 0.4);
    for (auto& z : wet) z = random.below(3) == 0 ? 0.0 : random.uniform(0.0, 0.02);
    std::vector<double> wide_wet = wet;
    const std::vector<double> solid_before = solid;
    DropletParams p;
    p.cap_radius_mm = random.uniform(0.07, 0.3);
    p.film_radius_mm = p.cap_radius_mm + random.uniform(0.0, 0.4);
    p.levelling_steps = int(random.below(4));
    const double dx = random.uniform(0.03, 0.09), dy = random.uniform(0.03, 0.09);
    const double u = random.uniform(0.0, nx), v = random.uniform(0.0, ny), depth = random.uniform(0.01, 0.5);
    footprint()({solid.data() + start, wide_wet.data() + start, stride, nx, ny}, p, depth, u, v, dx, dy);
    portable_footprint()({solid.data() + start, wet.data() + start, stride, nx, ny}, p, depth, u, v, dx, dy);
    INFO("trial " << trial << ", " << nx << " x " << ny);
    REQUIRE(std::memcmp(wide_wet.data(), wet.data(), wet.size() * sizeof(double)) == 0);
    REQUIRE(solid == solid_before);
  }
}
