#include "core/grid/offsets.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <set>

#include "core/grid/firing_order.h"
#include "core/grid/random.h"

using namespace firn;

namespace {

const GridSpec kNineBySeven{9, 7, 0.25, 0.2, -1.0, 3.0};

Placement random_placement(const GridSpec& g, const OffsetOptions& options, RandomStream& random) {
  Placement p{OffsetTable(options), OffsetMap(g), 0.0};
  for (auto& index : p.map.cells) index = std::uint8_t(random.below(std::uint32_t(p.table.size())));
  return p;
}

DropletPattern random_pattern(const GridSpec& g, RandomStream& random) {
  DropletPattern p(g);
  for (auto& c : p.cells) c = std::uint8_t(random.below(3));
  return p;
}

}  // namespace

TEST_CASE("A table of places has the centre as number 0 and is symmetric about it") {
  CHECK(OffsetTable().size() == 1);
  const OffsetTable x4({OffsetKind::kX, 4, 8});
  REQUIRE(x4.size() == 5);
  CHECK(x4[0] == Offset{});
  CHECK(x4[1] == Offset{-0.375, 0.0});
  CHECK(x4[2] == Offset{-0.125, 0.0});
  CHECK(x4[4] == Offset{0.375, 0.0});
  CHECK(x4.sub_rows() == 1);
  CHECK(OffsetTable({OffsetKind::kX, 3, 1}).size() == 3);
  for (int nx = 1; nx <= kMaxPositions; ++nx)
    for (int ny = 1; ny <= kMaxPositions; ++ny) {
      const OffsetTable t({OffsetKind::kGrid, nx, ny});
      REQUIRE(t.size() == nx * ny + (nx % 2 == 0 || ny % 2 == 0));
      CHECK(t.sub_rows() == ny + (ny % 2 == 0));
      CHECK(t[0] == Offset{});
      for (int n = 0; n < t.size(); ++n) {
        CHECK(t.nearest(t[n]) == n);
        CHECK(t[t.nearest({-t[n].x, -t[n].y})] == Offset{0.0 - t[n].x, 0.0 - t[n].y});
        CHECK((std::abs(t[n].x) < 0.5 && std::abs(t[n].y) < 0.5));
        for (int m = 0; m < t.size(); ++m) CHECK((t.sub_row(n) < t.sub_row(m)) == (t[n].y < t[m].y));
      }
    }
  CHECK_THROWS_WITH(OffsetTable({OffsetKind::kX, 9, 1}), Catch::Contains("positions_x"));
}

TEST_CASE("With a second size of droplet a table has each place twice, first those of the first size") {
  for (const OffsetKind kind : {OffsetKind::kX, OffsetKind::kGrid}) {
    const OffsetTable one({kind, 4, 3}), two({kind, 4, 3, 0.45});
    CHECK(one.places() == one.size());
    REQUIRE(two.size() == 2 * one.size());
    CHECK(two.places() == one.size());
    CHECK(two.sub_rows() == one.sub_rows());
    for (int n = 0; n < two.size(); ++n) {
      CHECK(two.place(n) == n % one.size());
      CHECK(two[n] == one[two.place(n)]);
      CHECK(two.sub_row(n) == one.sub_row(two.place(n)));
      CHECK(two.small(n) == (n >= one.size()));
      CHECK(two.share(n) == (two.small(n) ? 0.45 : 1.0));
      CHECK(two.nearest(two[n]) == two.place(n));
    }
  }
  CHECK_NOTHROW(OffsetTable({OffsetKind::kGrid, 7, 9 - 1, 0.5}));
  CHECK_THROWS_WITH(OffsetTable({OffsetKind::kGrid, 8, 8, 0.5}), Catch::Contains("more than 128"));
}

TEST_CASE("A place beyond the table is refused with its cell") {
  Placement p{OffsetTable({OffsetKind::kX, 4, 1}), OffsetMap(kNineBySeven), 0.0};
  CHECK_NOTHROW(check(p, kNineBySeven));
  p.map.at(3, 2) = 5;
  CHECK_THROWS_WITH(check(p, kNineBySeven), Catch::Contains("cell (3, 2)") && Catch::Contains("5 places"));
  CHECK_THROWS_WITH(check(p, GridSpec{4, 4}), Catch::Contains("16 cells"));
}

TEST_CASE(
    "A map of places that are all centres fires the cells of a pass without one, as do places along x") {
  RandomStream random(1, Purpose::kPattern);
  for (int trial = 0; trial < 20; ++trial) {
    const DropletPattern drops = random_pattern(kNineBySeven, random);
    const Placement placed = random_placement(kNineBySeven, {OffsetKind::kX, 4, 1}, random);
    const Placement centres{placed.table, OffsetMap(kNineBySeven), 0.0};
    auto without = firing_order(drops, 0);
    for (const Placement& p : {placed, centres}) {
      const auto runs = firing_runs(drops, 0, p);
      auto with = firing_order(drops, 0, p);
      std::set<int> rows;
      for (std::size_t n = 0; n < runs.size(); ++n) {
        CHECK(rows.insert(runs[n].row).second);
        CHECK(runs[n].towards_plus_x == (n % 2 == 0));
      }
      std::ranges::sort(with);
      std::ranges::sort(without);
      CHECK(with == without);
    }
  }
}

TEST_CASE("Every droplet of a pass lies in one run, the runs ascend in y and turn back, each monotone in x") {
  RandomStream random(2, Purpose::kPattern);
  for (int trial = 0; trial < 50; ++trial) {
    const DropletPattern drops = random_pattern(kNineBySeven, random);
    Placement p = random_placement(kNineBySeven, {OffsetKind::kGrid, 4, 3}, random);
    p.apart_mm = trial % 2 ? 0.19 : 0.0;  // neighbours are 0.25 mm apart, places up to 0.1875 mm nearer
    std::map<std::uint32_t, int> fired;
    double last_y = -1e9;
    bool towards_plus = false;
    std::map<double, int> runs_at;
    for (const FiringRun& run : firing_runs(drops, 1, p)) {
      CHECK(run.towards_plus_x != towards_plus);
      towards_plus = run.towards_plus_x;
      const double y = kNineBySeven.y_mm(run.row) + run.y * kNineBySeven.pitch_y_mm;
      CHECK(y >= last_y);
      last_y = y;
      CHECK(++runs_at[y] <= (p.apart_mm > 0.0 ? 2 : 1));
      double before = towards_plus ? -1e9 : 1e9;
      REQUIRE_FALSE(run.cells.empty());
      for (const std::uint32_t c : run.cells) {
        ++fired[c];
        CHECK(int(c) / kNineBySeven.nx == run.row);
        CHECK(p.of(c).y == run.y);
        const double x = kNineBySeven.x_mm(int(c) % kNineBySeven.nx) + p.of(c).x * kNineBySeven.pitch_x_mm;
        const double way = towards_plus ? x - before : before - x;
        CHECK(way > 0.0);
        CHECK(way >= p.apart_mm - 1e-12);
        before = x;
      }
    }
    for (std::uint32_t c = 0; c < drops.size(); ++c) CHECK(fired[c] == (drops.cells[c] > 1));
  }
}

TEST_CASE("Droplets that are just as far apart as a run wants lie in one run, nearer ones in two") {
  const GridSpec g{6, 1, 0.25, 0.25};
  DropletPattern drops(g);
  for (std::uint8_t& n : drops.cells) n = 1;
  Placement p{OffsetTable({OffsetKind::kGrid, 1, 1}), OffsetMap(g), 0.25};
  CHECK(firing_runs(drops, 0, p).size() == 1);
  p.apart_mm = 0.26;
  CHECK(firing_runs(drops, 0, p).size() == 2);
}

TEST_CASE(
    "Cell, place, nozzle and lead add in one place, and the part's point is that of the sum without them") {
  const Offset place{0.375, -0.125};
  const Aim aim{20.0, -0.5, 0.075};
  for (const bool towards_plus : {true, false}) {
    const StagePlace s = stage_place(kNineBySeven, 3, 2, place, aim, towards_plus);
    const double direction = towards_plus ? 1.0 : -1.0;
    CHECK(s.x_mm == Approx(-1.0 + 3 * 0.25 + 0.375 * 0.25 - 20.0 - direction * 0.075).margin(1e-12));
    CHECK(s.y_mm == Approx(3.0 + 2 * 0.2 - 0.125 * 0.2 + 0.5).margin(1e-12));
    const StagePlace p = part_place(s, aim, towards_plus);
    CHECK(p.x_mm == Approx(kNineBySeven.x_mm(3) + place.x * kNineBySeven.pitch_x_mm).margin(1e-12));
    CHECK(p.y_mm == Approx(kNineBySeven.y_mm(2) + place.y * kNineBySeven.pitch_y_mm).margin(1e-12));
  }
}
