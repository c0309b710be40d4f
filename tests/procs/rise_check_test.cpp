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
  /// From now on droplets lie in pits: all of a droplet stays on its own cell.
  void dig() { in_pits_ = true; }
  /// From now on the plateau is a wall that each scan meets at another place of its rim's cells.
  void build_wall(double height_mm, double jitter_mm) {
    for (int j = 3; j < 3 + side_; ++j)
      for (int i = 3; i < 3 + side_; ++i) surface_.at(i, j) += height_mm;
    jitter_mm_ = jitter_mm;
    before_ = measured();
  }
  /// From now on a droplet's ink ends up evenly over so many cells to either side.
  void flow(int reach) { reach_ = reach; }
  /// From now on all cells of a row share an error of each scan.
  void share_errors(double row_mm) {
    row_mm_ = row_mm;
    before_ = measured();
  }
  /// From now on every second column is of ink B, whose droplets add so many times their height.
  void second_ink(double share) {
    inks_ = MaterialMap(e_.grid);
    for (int j = 0; j < e_.grid.ny; ++j)
      for (int i = 0; i < e_.grid.nx; i += 2) inks_.at(i, j) = std::uint8_t(Material::kB);
    share_b_ = share;
  }
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
        const bool b = !inks_.cells.empty() && inks_.of(e_.grid.index(i, j)) == Material::kB;
        const double volume = (b ? share_b_ : share) * (1.0 + 0.1 * random_.normal());
        if (reach_ > 0) {
          const double side = 2.0 * reach_ + 1.0, all = h[0] + 4.0 * h[1] + 4.0 * h[2];
          for (int y = j - reach_; y <= j + reach_; ++y)
            for (int x = i - reach_; x <= i + reach_; ++x)
              if (e_.grid.contains(x, y)) surface_.at(x, y) += volume * all / (side * side);
          continue;
        }
        if (in_pits_) {
          surface_.at(i, j) += volume * (h[0] + 4.0 * h[1] + 4.0 * h[2]);
          continue;
        }
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
    const Violation what = check_.check(e_, {before_, after, noise_mm_, noise_mm_, drops, inks_, places});
    before_ = after;
    return what;
  }

 private:
  HeightMap measured() {
    HeightMap m = surface_;
    for (double& h : m.cells) h += noise_mm_ * random_.normal();
    for (int j = 0; row_mm_ > 0.0 && j < e_.grid.ny; ++j) {
      const double error = row_mm_ * random_.normal();
      for (int i = 0; i < e_.grid.nx; ++i) m.at(i, j) += error;
    }
    const int last = 2 + side_;
    for (int j = 3; j <= last; ++j)
      for (int i = 3; i <= last; ++i)
        if (i == 3 || j == 3 || i == last || j == last) m.at(i, j) += jitter_mm_ * random_.normal();
    return m;
  }

  int side_;
  double noise_mm_;
  bool in_pits_ = false;
  int reach_ = 0;
  double row_mm_ = 0.0;
  double jitter_mm_ = 0.0;
  double share_b_ = 1.0;
  RandomStream random_;
  Experiment e_;
  MaterialMap inks_;
  HeightMap surface_, before_;
  RiseCheck check_;
};

/// Layers until the check finds something; 0: it does not within `layers`.
int found_after(Printer& printer, int layers, double share, double fill = 1.0) {
  for (int n = 1; n <= layers; ++n)
    if (const Violation what = printer.layer(share, fill); !what.empty()) {
      UNSCOPED_INFO(what.text);
      return n;
    }
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

TEST_CASE("Droplets in pits, which take what the model gives to the walls, are no leak", "[I12]") {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    RandomStream random(seed, Purpose::kInstance);
    Printer printer(3 + int(random.below(12)), 0.001 * random.uniform(0.2, 1.5), seed);
    printer.experiment().actuation.offsets = OffsetKind::kGrid;
    printer.dig();
    INFO("seed " << seed);
    CHECK(found_after(printer, 50, random.uniform(0.7, 1.5), random.uniform(0.02, 1.0)) == 0);
  }
}

TEST_CASE("Ink that flows off its cells is no dead nozzle, and where none comes one is found", "[I12]") {
  for (std::uint64_t seed = 1; seed <= 30; ++seed)
    for (const int reach : {1, 2, 3}) {
      RandomStream random(seed, Purpose::kInstance);
      Printer printer(6 + int(random.below(12)), 0.001 * random.uniform(0.2, 1.5), seed);
      printer.flow(reach);
      INFO("seed " << seed << ", " << reach << " cells far");
      CHECK(found_after(printer, 50, random.uniform(0.8, 1.2), random.uniform(0.02, 1.0)) == 0);
      Printer dead(10, 0.001, seed);
      dead.flow(reach);
      for (int n = 0; n < 5; ++n) CHECK(dead.layer(1.0).empty());
      CHECK(found_after(dead, 2, 0.0) > 0);
    }
}

TEST_CASE("Errors that all cells of a profile share are no ink, and no droplets that miss", "[I12]") {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    RandomStream random(seed, Purpose::kInstance);
    Printer printer(8 + int(random.below(8)), 0.001, seed);
    printer.share_errors(random.uniform(0.002, 0.012));
    INFO("seed " << seed);
    CHECK(found_after(printer, 50, random.uniform(0.8, 1.2), random.uniform(0.01, 1.0)) == 0);
  }
}

TEST_CASE("A leak beside full layers is found by the volume that the droplets do not explain", "[I12]") {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Printer printer(12, 0.001, seed);
    for (int n = 0; n < 10; ++n) CHECK(printer.layer(0.85).empty());
    CHECK_THAT(printer.layer(0.85, 1.0, 0.8 * 0.0076).text, Catch::Contains("a nozzle leaks"));
  }
}

TEST_CASE("Scans that meet a wall at different places stop no print, and a dead nozzle beside it is found",
          "[I12]") {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    RandomStream random(seed, Purpose::kInstance);
    const int side = 4 + int(random.below(12));
    Printer printer(side, 0.0005, seed);
    printer.build_wall(0.4, 0.02);
    INFO("seed " << seed);
    CHECK(found_after(printer, 50, random.uniform(0.7, 1.2), random.uniform(0.02, 1.0)) == 0);
    Printer dead(10, 0.0005, seed);
    dead.build_wall(0.4, 0.02);
    for (int n = 0; n < 5; ++n) CHECK(dead.layer(1.0).empty());
    CHECK(found_after(dead, 2, 0.0) > 0);
  }
}

TEST_CASE("Of two inks in alternating columns the one that gives eight times its droplets is named",
          "[I12]") {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Printer printer(8, 0.001, seed);
    printer.second_ink(1.0);
    for (int n = 0; n < 20; ++n) CHECK(printer.layer(1.0).empty());
    printer.second_ink(8.0);
    CHECK_THAT(printer.layer(1.0).text, Catch::StartsWith("jet_b: ") && Catch::Contains("it gives too much"));
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
