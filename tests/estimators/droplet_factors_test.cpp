#include "estimators/droplet/droplet_factors.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/grid/random.h"

using namespace firn;
using namespace firn::droplet;

namespace {

Mask disc(const GridSpec& g, double radius) {
  Mask m(g);
  for (int j = 0; j < g.ny; ++j)
    for (int i = 0; i < g.nx; ++i) {
      const double x = i - 0.5 * (g.nx - 1), y = j - 0.5 * (g.ny - 1);
      m.at(i, j) = x * x + y * y <= radius * radius;
    }
  return m;
}

// A part whose droplets add `factor` of the model's, on a map with noise.
struct Print {
  GridSpec grid{24, 24};
  Mask mask = disc(grid, 10.0);
  deposition::DropletModel nature;
  HeightMap height{grid, 0.0};
  RandomStream random{5, Purpose::kTest};
  std::vector<Use> use = std::vector<Use>(grid.size(), Use::kNothing);
  DropletFactors factors{grid, mask, {}};
  explicit Print(deposition::DropletModel model = {}) : nature(model) {
    for (std::size_t c = 0; c < use.size(); ++c)
      if (mask.cells[c]) use[c] = Use::kLearn;
  }
  void layer(double factor, double fill, double noise_mm) {
    Pass pass;
    DropletPattern u(grid);
    for (std::uint32_t c = 0; c < u.size(); ++c)
      if (mask.cells[c] && random.uniform(0.0, 1.0) < fill) {
        u.cells[c] = 1;
        pass.cells.push_back(c);
      }
    const HeightMap before = height;
    deposition::HeightChange<1>(grid, deposition::stencil_of(nature.times(factor)), deposition::Border::kLose)
        .step(height.data(), u.data(), 0);
    HeightMap map = height;
    for (double& h : map.cells) h += random.uniform(-1.7, 1.7) * noise_mm;
    factors.add_layer(before.cells, std::vector<Pass>{pass}, map.cells, use);
  }
};

/// Full layers of a jet whose flow wanders by 2 % a layer. @return how far the factor inside is off at most,
/// after `settled` layers
double worst_lag(Print& p, double& factor, int layers, int settled, double noise_mm) {
  double worst = 0.0;
  for (int layer = 1; layer <= layers; ++layer) {
    factor = std::min(1.25, std::max(0.75, factor + p.random.uniform(-0.034, 0.034)));
    p.layer(factor, 1.0, noise_mm);
    if (layer > settled) worst = std::max(worst, std::abs(p.factors.at(Place::kInside) - factor));
  }
  return worst;
}

}  // namespace

TEST_CASE("A part's cells are rim, two rows between and inside, and a narrow part has no row between") {
  const GridSpec g{20, 15};
  Mask m(g, 1);
  m.at(4, 7) = 0;  // a hole has a rim too
  const Grid<Place> place = places_of(m);
  CHECK(place.at(0, 0) == Place::kRim);
  CHECK(place.at(5, 8) == Place::kRim);
  CHECK(place.at(1, 4) == Place::kBetween);
  CHECK(place.at(7, 7) == Place::kBetween);
  CHECK(place.at(17, 7) == Place::kBetween);
  CHECK(place.at(8, 7) == Place::kInside);
  CHECK(place.at(16, 7) == Place::kInside);
  const Grid<Place> narrow = places_of(Mask(GridSpec{5, 30}, 1));
  CHECK(narrow.at(0, 7) == Place::kRim);
  CHECK(narrow.at(1, 7) == Place::kInside);
  CHECK(places_of(Mask(GridSpec{15, 15}, 1)).at(7, 7) == Place::kInside);
}

TEST_CASE(
    "A jet whose flow wanders by 2 % a layer is followed to 3 %, from full layers under 1 um of noise") {
  Print p;
  double factor = 0.9;
  CHECK(worst_lag(p, factor, 40, 5, 1e-3) < 0.03);
  CHECK(std::abs(p.factors.at(Place::kRim) / p.factors.at(Place::kInside) - 1.0) < 0.1);
}

TEST_CASE("Layers of few droplets hardly move what full layers have told") {
  Print p;
  for (int layer = 1; layer <= 10; ++layer) p.layer(0.8, 1.0, 1e-3);
  const double told = p.factors.at(Place::kInside);
  CHECK(std::abs(told - 0.8) < 0.02);
  for (int layer = 1; layer <= 5; ++layer) p.layer(0.8, 0.02, 1e-3);
  CHECK(std::abs(p.factors.at(Place::kInside) - told) < 0.02);
}

TEST_CASE(
    "Weighed by fill, a full layer tells the flow to 1 % at once, and what half-filled ones tell too much is "
    "not believed") {
  DropletFactorOptions o;
  o.sparse_std = 0.4;
  Print p;
  p.factors = DropletFactors(p.grid, p.mask, o);
  double factor = 0.9;
  CHECK(worst_lag(p, factor, 30, 1, 3e-4) < 0.01);
  const double told = p.factors.at(Place::kInside);
  for (int layer = 1; layer <= 3; ++layer) p.layer(1.25 * factor, 0.2, 3e-4);
  CHECK(std::abs(p.factors.at(Place::kInside) - told) < 0.25 * std::abs(1.25 * factor - told));
}

TEST_CASE("Droplets that spread wider than the model's, with the same volume, do not pass for smaller ones") {
  Print p({2.8e-3, 0.9e-3, 0.3e-3});
  for (int layer = 1; layer <= 12; ++layer) p.layer(1.0, 0.5, 1e-4);
  CHECK(std::abs(p.factors.at(Place::kInside) - 1.0) < 0.02);
}

TEST_CASE("A rim whose droplets run off is not believed to take less than most of the inside's") {
  Print p;
  for (int layer = 1; layer <= 10; ++layer) p.layer(1.0, 1.0, 1e-4);
  HeightMap flat(p.grid, 0.5), after = flat;
  Pass rim;
  for (std::uint32_t c = 0; c < p.grid.size(); ++c)
    if (p.mask.cells[c] && p.factors.places().cells[c] == Place::kRim) {
      rim.cells.push_back(c);
      after.cells[c] += 2.5e-3;
    }
  for (int layer = 1; layer <= 30; ++layer)
    p.factors.add_layer(flat.cells, std::vector<Pass>{rim}, after.cells, p.use);
  CHECK(p.factors.at(Place::kRim) == Approx(DropletFactors::kMinRim * p.factors.at(Place::kInside)));
}

TEST_CASE("Options of the droplet factors out of range are refused by name") {
  const GridSpec g{8, 8};
  DropletFactorOptions o;
  o.prior_std = 0.0;
  CHECK_THROWS_WITH(DropletFactors(g, Mask(g, 1), o), Catch::Matchers::Contains("prior_std"));
  o = {};
  o.walk_std[1] = -1.0;
  CHECK_THROWS_WITH(DropletFactors(g, Mask(g, 1), o), Catch::Matchers::Contains("walk_std"));
  o = {};
  o.sparse_std = -0.1;
  CHECK_THROWS_WITH(DropletFactors(g, Mask(g, 1), o), Catch::Matchers::Contains("sparse_std"));
  CHECK_THROWS_WITH(DropletFactors(g, Mask(GridSpec{8, 7}, 1), {}), Catch::Matchers::Contains("mask"));
}
