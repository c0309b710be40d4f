// Interlock 12 of droplets: errors of both kinds by drawn layers, against the limits that its header derives.
#include "procs/scheduler/rise_check.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/deposition/offset_change.h"
#include "core/grid/random.h"

namespace firn {
namespace {

/// A printer with a plateau of `side` x `side` cells in the middle of bare ground.
class Printer {
 public:
  Printer(int side, double noise_mm, std::uint64_t seed)
      : side_(side), noise_mm_(noise_mm), random_(seed, Purpose::kTest) {
    e_.grid = GridSpec{side + 6, side + 6};
    surface_ = HeightMap(e_.grid);
    before_ = measured();
  }
  Experiment& experiment() { return e_; }
  /// Prints a layer of which each droplet adds `share` of its height. @returns the finding of the check
  Violation layer(double share, double fill = 1.0, double leak_mm = 0.0) {
    DropletPattern drops(e_.grid);
    const OffsetTable table(e_.actuation);
    OffsetMap places = table.size() > 1 ? OffsetMap(e_.grid) : OffsetMap();
    for (auto& place : places.cells) place = std::uint8_t(random_.below(std::uint32_t(table.size())));
    for (int j = 3; j < 3 + side_; ++j)
      for (int i = 3; i < 3 + side_; ++i) drops.at(i, j) = random_.uniform() < fill;
    const double h[3] = {e_.model.h1_mm, e_.model.h2_mm, e_.model.h3_mm};
    for (int j = 0; j < e_.grid.ny; ++j)
      for (int i = 0; i < e_.grid.nx; ++i) {
        surface_.at(i, j) += leak_mm;
        if (drops.at(i, j) == 0) continue;
        const double volume = share * (1.0 + 0.1 * random_.normal());
        if (!places.cells.empty()) {
          const deposition::OffsetKernel k =
              deposition::mixed_kernel({h[0], h[1], h[2]}, table[places.of(e_.grid.index(i, j))]);
          for (int y = -2; y <= 2; ++y)
            for (int x = -2; x <= 2; ++x) surface_.at(i + x, j + y) += volume * k.at(x, y);
          continue;
        }
        for (int y = j - 1; y <= j + 1; ++y)
          for (int x = i - 1; x <= i + 1; ++x)
            surface_.at(x, y) += volume * h[std::abs(x - i) + std::abs(y - j)];
      }
    const HeightMap after = measured();
    const Violation what = check_.check(e_, {before_, after, noise_mm_, noise_mm_, drops, {}, places});
    before_ = after;
    return what;
  }

 private:
  HeightMap measured() {
    HeightMap m = surface_;
    for (double& h : m.cells) h += noise_mm_ * random_.normal();
    return m;
  }

  int side_;
  double noise_mm_;
  RandomStream random_;
  Experiment e_;
  HeightMap surface_, before_;
  RiseCheck check_;
};

/// Layers until the check finds something; 0: it does not within `layers`.
int found_after(Printer& printer, int layers, double share, double fill = 1.0) {
  for (int n = 1; n <= layers; ++n)
    if (!printer.layer(share, fill).empty()) return n;
  return 0;
}

}  // namespace

TEST_CASE("A dead nozzle is found within two layers where 30 cells are inside the part, at 1 um a cell",
          "[I12]") {
  for (const double noise_mm : {0.0003, 0.001})
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
      Printer printer(8, noise_mm, seed);
      for (int n = 0; n < 5; ++n) CHECK(printer.layer(1.0).empty());
      const int found = found_after(printer, 2, 0.0);
      INFO("noise " << noise_mm << ", seed " << seed);
      CHECK(found > 0);
    }
}

TEST_CASE("A nozzle that fires well is never stopped, however few droplets a layer has", "[I12]") {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    RandomStream random(seed, Purpose::kInstance);
    Printer printer(3 + int(random.below(12)), 0.001 * random.uniform(0.2, 1.5), seed);
    INFO("seed " << seed);
    CHECK(found_after(printer, 50, random.uniform(0.7, 1.2), random.uniform(0.02, 1.0)) == 0);
  }
}

TEST_CASE("A nozzle that fires well beside the centres is never stopped, and a dead one is found", "[I12]") {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    RandomStream random(seed, Purpose::kInstance);
    Printer printer(3 + int(random.below(12)), 0.001 * random.uniform(0.2, 1.5), seed);
    printer.experiment().actuation.offsets = OffsetKind::kGrid;
    INFO("seed " << seed);
    CHECK(found_after(printer, 50, random.uniform(0.7, 1.2), random.uniform(0.02, 1.0)) == 0);
    Printer dead(8, 0.001, seed);
    dead.experiment().actuation.offsets = OffsetKind::kX;
    for (int n = 0; n < 5; ++n) CHECK(dead.layer(1.0).empty());
    CHECK(found_after(dead, 2, 0.0) > 0);
  }
}

TEST_CASE("A nozzle at the limit of process.least_rise_share is stopped less than once in 1,000 layers",
          "[I12]") {
  int stops = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    Printer printer(8, 0.001, seed);
    for (int n = 0; n < 50; ++n) stops += !printer.layer(0.3 * 1.01).empty();
  }
  CHECK(stops <= 2);
}

TEST_CASE("Noise of bare ground is no leak, and ground that rises by half a layer is one", "[I12]") {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Printer printer(4, 0.001, seed);
    for (int n = 0; n < 20; ++n) CHECK(printer.layer(1.0).empty());
    const Violation leak = printer.layer(1.0, 1.0, 0.5 * 0.0076);
    CHECK_THAT(leak.text, Catch::Contains("a nozzle leaks"));
  }
}

TEST_CASE("A nozzle that gives six times its droplets is found at the first layer", "[I12]") {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Printer printer(8, 0.001, seed);
    CHECK_THAT(printer.layer(6.0).text, Catch::Contains("it gives too much"));
  }
}

}  // namespace firn
