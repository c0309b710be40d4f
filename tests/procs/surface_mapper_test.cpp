#include "procs/surface_mapper/node.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/grid/npy.h"
#include "core/grid/random.h"
#include "firn/enums.h"
#include "firn/fault_t.hpp"
#include "firn/height_map_t.hpp"
#include "lcmtypes/convert.h"
#include "tests/support/node_bench.h"

namespace firn {
namespace {

Experiment small_plate() {
  Experiment e;
  e.grid = {8, 6, 0.25, 0.25, 2.0, 1.0};
  e.part.shape.diameter_mm = 1.2;
  return e;
}

Mask mapped_disc() {
  Mask m(small_plate().grid);
  for (int j = 1; j < 5; ++j)
    for (int i = 1; i < 7; ++i) m.at(i, j) = 1;
  return m;
}

struct MapperBench : test::NodeBench {
  explicit MapperBench(const Experiment& e = small_plate())
      : NodeBench(NodeId::kSurfaceMapper, std::make_unique<SurfaceMapper>(e, mapped_disc())) {
    start();
  }

  height_profile_t row(int j, std::int64_t scan_id, int layer, double height_mm) const {
    const GridSpec g = small_plate().grid;
    height_profile_t p{};
    p.layer = layer;
    p.scan_id = scan_id;
    p.row = j;
    p.rows = g.ny;
    p.sample_utime_us = 1000 * scan_id + j;
    p.dx_mm = 0.025;
    p.x0_mm = g.x_mm(0) - 0.1125;
    p.y_mm = g.y_mm(j);
    for (int n = 0; n < 80; ++n) p.z_mm.push_back(float(height_mm + 0.001 * j));
    p.n = 80;
    return p;
  }
  scan_done_t done(std::int64_t scan_id, int layer, int received = 6, int attempt = 0) const {
    scan_done_t d{};
    d.layer = layer;
    d.attempt = attempt;
    d.scan_id = scan_id;
    d.rows_expected = 6;
    d.rows_received = received;
    return d;
  }
  void scan(std::int64_t scan_id, int layer, double height_mm) {
    for (int j = 0; j < 6; ++j) give(channels::kHeightProfile, row(j, scan_id, layer, height_mm));
    give(channels::kScanDone, done(scan_id, layer));
  }
  std::vector<height_map_t> maps() const { return all(channels::kHeightMap); }
  std::size_t faults() const { return all(channels::fault(NodeId::kSurfaceMapper)).size(); }
};

}  // namespace

TEST_CASE(
    "A scan becomes one map with layer, attempt, time of its last row and a new map_id, and a preview") {
  MapperBench bench;
  bench.scan(1, 0, 0.0);
  for (int j = 0; j < 6; ++j) bench.give(channels::kHeightProfile, bench.row(j, 2, 1, 0.5));
  bench.give(channels::kScanDone, bench.done(2, 1, 6, 3));
  const auto maps = bench.maps();
  REQUIRE(maps.size() == 2);
  CHECK(maps[0].map_id != maps[1].map_id);
  CHECK(maps[1].layer == 1);
  CHECK(maps[1].attempt == 3);
  CHECK(maps[1].sample_utime_us == 2005);
  CHECK(maps[1].measured_fraction == 1.0);
  CHECK(from_message(maps[1].grid) == small_plate().grid);
  for (int c = 0; c < 48; ++c) {
    CHECK(double(maps[1].height_mm[std::size_t(c)]) == Approx(0.5 + 0.001 * (c / 8)).margin(1e-6));
    CHECK(maps[1].quality[std::size_t(c)] == 0);
  }
  CHECK(bench.all(channels::kHeightPreview).size() == 2);
  CHECK(bench.faults() == 0);
}

TEST_CASE("Rows in any order, repeated rows and SCAN_DONE before the last rows give the same map bytes") {
  MapperBench plain;
  plain.scan(1, 4, 0.2);
  RandomStream random(1, Purpose::kTest);
  for (int trial = 0; trial < 20; ++trial) {
    MapperBench mixed;
    std::vector<int> order = {0, 1, 2, 3, 4, 5, 2, 5};
    for (std::size_t n = order.size(); n > 1; --n)
      std::swap(order[n - 1], order[random.below(std::uint32_t(n))]);
    const std::size_t done_at = random.below(9);
    for (std::size_t n = 0; n <= order.size(); ++n) {
      if (n == done_at) mixed.give(channels::kScanDone, mixed.done(1, 4));
      if (n < order.size()) mixed.give(channels::kHeightProfile, mixed.row(order[n], 1, 4, 0.2));
    }
    REQUIRE(mixed.maps().size() == 1);
    CHECK(mixed.maps()[0].height_mm == plain.maps()[0].height_mm);
    CHECK(mixed.maps()[0].sample_utime_us == plain.maps()[0].sample_utime_us);
    CHECK(mixed.faults() == 0);
  }
}

TEST_CASE("Missing rows are waited for, then filled, marked and told") {
  MapperBench bench;
  for (int j : {0, 1, 2, 4, 5}) bench.give(channels::kHeightProfile, bench.row(j, 1, 2, 0.1));
  bench.give(channels::kScanDone, bench.done(1, 2));
  CHECK(bench.maps().empty());
  REQUIRE(bench.wake());
  CHECK(bench.now.us == 2'000'000);
  REQUIRE(bench.maps().size() == 1);
  const height_map_t m = bench.maps()[0];
  CHECK(m.measured_fraction == Approx(5.0 / 6.0));
  CHECK(m.rows_expected == 6);
  CHECK(m.rows_received == 5);
  for (int c = 0; c < 48; ++c) CHECK(int(m.quality[std::size_t(c)]) == (c / 8 == 3 ? 1 : 0));
  CHECK(bench.faults() == 1);
  bench.give(channels::kHeightProfile, bench.row(3, 1, 2, 0.1));  // too late
  bench.give(channels::kScanDone, bench.done(1, 2));
  CHECK(bench.maps().size() == 1);
}

TEST_CASE("A row that the profiler itself did not receive is not waited for") {
  MapperBench bench;
  for (int j : {0, 1, 2, 4, 5}) bench.give(channels::kHeightProfile, bench.row(j, 1, 2, 0.1));
  bench.give(channels::kScanDone, bench.done(1, 2, 5));
  REQUIRE(bench.maps().size() == 1);
  CHECK(bench.maps()[0].measured_fraction < 0.9);
  CHECK(bench.maps()[0].rows_received == 5);
}

TEST_CASE("Rows of an older scan change nothing, and a newer scan drops the unfinished one and says so") {
  MapperBench bench;
  bench.scan(5, 1, 0.1);
  bench.give(channels::kHeightProfile, bench.row(0, 4, 1, 9.0));
  bench.give(channels::kScanDone, bench.done(4, 1));
  CHECK(bench.maps().size() == 1);
  for (int j = 0; j < 3; ++j) bench.give(channels::kHeightProfile, bench.row(j, 6, 2, 7.0));
  bench.scan(7, 2, 0.2);
  REQUIRE(bench.maps().size() == 2);
  CHECK(double(bench.maps()[1].height_mm[0]) == Approx(0.2).margin(1e-6));
  CHECK(bench.faults() == 1);
}

TEST_CASE("A malformed row is left out and named, and the map is made from the others") {
  const auto broken = [](auto change) {
    MapperBench bench;
    for (int j : {0, 1, 2, 3, 4}) bench.give(channels::kHeightProfile, bench.row(j, 1, 0, 0.1));
    height_profile_t bad = bench.row(5, 1, 0, 0.1);
    change(bad);
    bench.give(channels::kHeightProfile, bad);
    bench.give(channels::kScanDone, bench.done(1, 0, 5));
    REQUIRE(bench.maps().size() == 1);
    REQUIRE(bench.faults() == 1);
    const height_map_t map = bench.maps()[0];
    CHECK(map.measured_fraction < 0.9);
    for (float h : map.height_mm) CHECK(std::isfinite(h));
    return bench.last(channels::fault(NodeId::kSurfaceMapper)).text;
  };
  CHECK_THAT(broken([](auto& p) { p.row = 6; }), Catch::Contains("row = 6"));
  CHECK_THAT(broken([](auto& p) { p.row = -1; }), Catch::Contains("row = -1"));
  CHECK_THAT(broken([](auto& p) { p.rows = 2'000'000'000; }), Catch::Contains("rows = 2000000000"));
  CHECK_THAT(broken([](auto& p) { p.dx_mm = 0.0; }), Catch::Contains("dx_mm"));
  CHECK_THAT(broken([](auto& p) { p.x0_mm = std::nan(""); }), Catch::Contains("x0_mm"));
  CHECK_THAT(broken([](auto& p) { p.y_mm = INFINITY; }), Catch::Contains("y_mm"));
}

TEST_CASE("A scan without a single row is a map that measures nothing") {
  MapperBench bench;
  bench.give(channels::kScanDone, bench.done(1, 0, 0));
  REQUIRE(bench.maps().size() == 1);
  CHECK(bench.maps()[0].measured_fraction == 0.0);
  const height_map_t map = bench.maps()[0];
  for (float h : map.height_mm) CHECK(h == 0.0f);
}

TEST_CASE(
    "control.smoothing takes the noise out of the part and leaves the surroundings and their cliff alone") {
  Experiment e = small_plate();
  double error[2] = {};
  for (const bool on : {false, true}) {
    e.control.smoothing = on ? 1.0 : 0.0;
    MapperBench bench(e);
    RandomStream random(3, Purpose::kSensorNoise);
    for (int j = 0; j < 6; ++j) {
      height_profile_t p = bench.row(j, 1, 1, 0.0);
      for (int n = 0; n < 80; ++n) {
        const bool part = mapped_disc().at(n / 10, j);
        p.z_mm[std::size_t(n)] = float((part ? 0.4 : 0.0) + 0.01 * random.normal());
      }
      bench.give(channels::kHeightProfile, p);
    }
    bench.give(channels::kScanDone, bench.done(1, 1));
    const height_map_t map = bench.last(channels::kHeightMap);
    for (std::size_t c = 0; c < 48; ++c) {
      const double truth = mapped_disc().cells[c] ? 0.4 : 0.0;
      CHECK(std::abs(double(map.height_mm[c]) - truth) < 0.02);
      if (mapped_disc().cells[c])
        error[on] += (double(map.height_mm[c]) - truth) * (double(map.height_mm[c]) - truth);
    }
  }
  CHECK(error[1] < 0.5 * error[0]);
}

TEST_CASE("The mapper is built from the resolved configuration and the mask") {
  CHECK(make_surface_mapper(dump(small_plate()), {{"mask", "", to_npy(mapped_disc())}}) != nullptr);
  CHECK_THROWS_WITH(make_surface_mapper(dump(small_plate()), {}), Catch::Contains("mask"));
}

TEST_CASE("A preview keeps small maps as they are and reduces large ones by whole blocks to 60 kB") {
  const HeightMap h(small_plate().grid, 0.3);
  CHECK(preview_of(h, 1).n == 48);
  HeightMap large(GridSpec{1001, 640, 0.1, 0.1, 0.0, 0.0});
  for (int j = 0; j < 640; ++j)
    for (int i = 0; i < 1001; ++i) large.at(i, j) = large.spec.x_mm(i);
  const preview_t p = preview_of(large, 3);
  CHECK(p.getEncodedSize() <= 60'000);
  CHECK(p.n == p.grid.nx * p.grid.ny);
  for (int i = 0; i + 1 < p.grid.nx; ++i)
    CHECK(double(p.height_mm[std::size_t(i)]) ==
          Approx(p.grid.origin_x_mm + i * p.grid.pitch_x_mm).margin(1e-4));
}

}  // namespace firn
