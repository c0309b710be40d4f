// Common random numbers make two prints comparable pair by pair: the n-th droplet of layer k on cell c meets
// the same nature in both, independently of earlier droplets and neighbours, of order, and of the number of
// passes and cures.
#include <catch2/catch.hpp>

#include <algorithm>
#include <map>
#include <tuple>

#include "core/grid/random.h"
#include "plant/inkjet/model.h"
#include "plant/inkjet/sensor.h"

using namespace firn;
using namespace firn::plant;

namespace {

using DropletKey = std::tuple<int, std::size_t, int>;  // layer, cell, n-th of the layer there
struct Fate {
  bool missed;
  double volume_mm3, dx_mm, dy_mm;
  bool operator==(const Fate&) const = default;
};
using Fates = std::map<DropletKey, Fate>;

WorldConfig world(const char* model, std::uint64_t seed) {
  WorldConfig c;
  c.grid = {10, 9, 0.263256, 0.263256, 0.0, 0.0};
  c.model = model;
  c.seed = seed;
  c.nozzle.drift = false;
  c.lu2015.variation = 0.4;
  c.droplet.missed_probability = 0.2;
  c.droplet.satellite_probability = 0.3;
  return c;
}

// Prints layers of a random strategy: number of droplets, their order, a cure after every n-th one, one or
// more scans.
Fates print(const WorldConfig& c, std::uint64_t strategy, int layers) {
  const auto model = make_model(c);
  RandomStream random(strategy, Purpose::kTest);
  Fates fates;
  std::int64_t t_us = 0;
  for (int layer = 0; layer < layers; ++layer) {
    for (std::uint32_t scans = 1 + random.below(2); scans > 0; --scans) model->measured();
    std::vector<std::size_t> order;
    for (std::size_t cell = 0; cell < c.grid.size(); ++cell)
      for (std::uint32_t n = random.below(4); n > 0; --n) order.push_back(cell);
    for (std::size_t n = order.size(); n > 1; --n)
      std::swap(order[n - 1], order[random.below(std::uint32_t(n))]);
    const std::size_t cure_every = 1 + random.below(std::uint32_t(order.size()));
    std::vector<int> count(c.grid.size(), 0);
    for (std::size_t n = 0; n < order.size(); ++n) {
      const int i = int(order[n] % 10), j = int(order[n] / 10);
      const double x = c.grid.x_mm(i), y = c.grid.y_mm(j);
      const Landing l = model->fire({t_us += 2500, x, y, 0.0, 0.0});
      fates[{layer, order[n], count[order[n]]++}] = {l.missed, l.volume_mm3, l.x_mm - x, l.y_mm - y};
      if (n % cure_every == 0) model->expose(t_us += 2500);
    }
    model->expose(t_us += 2500);
  }
  return fates;
}

}  // namespace

TEST_CASE("the n-th droplet of a layer on a cell has one fate under every strategy, in both plants") {
  for (const char* name : {"droplets", "lu2015"})
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      CAPTURE(name, seed);
      const WorldConfig c = world(name, seed);
      const Fates a = print(c, 2 * seed, 6), b = print(c, 2 * seed + 1, 6);
      std::size_t common = 0;
      for (const auto& [key, fate] : a)
        if (const auto other = b.find(key); other != b.end()) {
          ++common;
          REQUIRE(fate == other->second);
        }
      CHECK(common > 200);
    }
}

TEST_CASE("fates differ between seeds, layers, cells and droplets of one cell") {
  for (const char* name : {"droplets", "lu2015"}) {
    CAPTURE(name);
    const Fates a = print(world(name, 1), 5, 6), b = print(world(name, 2), 5, 6);
    std::map<double, int> volumes;
    for (const auto& [key, fate] : a) {
      if (fate.missed) continue;
      ++volumes[fate.volume_mm3];
      if (const Fate& other = b.at(key); !other.missed) CHECK(fate.volume_mm3 != other.volume_mm3);
    }
    for (const auto& [volume, times] : volumes) CHECK(times == 1);
  }
}

TEST_CASE(
    "the wander of the nozzle and the noise of a scan belong to the layer, however often it was cured") {
  WorldConfig c = world("droplets", 4);
  c.nozzle.drift = true;
  c.droplet.size_scatter = c.droplet.missed_probability = 0.0;
  // Two hours at rest after each cure: the firing history is forgotten and only the wander's target is left.
  const auto volumes = [&](int cures) {
    const auto model = make_model(c);
    std::vector<double> out;
    std::int64_t t_us = 0;
    for (int layer = 0; layer < 5; ++layer) {
      model->measured();
      t_us += 7'200'000'000;
      out.push_back(model->fire({t_us, 0.0, 0.0, 0.0, 0.0}).volume_mm3);
      for (int n = 0; n < cures; ++n) model->expose(t_us);
    }
    return out;
  };
  const auto one = volumes(1), four = volumes(4);
  for (std::size_t n = 0; n < one.size(); ++n) CHECK(one[n] == Approx(four[n]).epsilon(1e-6));
  CHECK(one[2] != Approx(one[3]).epsilon(1e-4));
}
