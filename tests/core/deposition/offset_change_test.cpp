#include "core/deposition/offset_change.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>

#include "core/deposition/two_materials.h"
#include "core/grid/random.h"

using namespace firn;
using namespace firn::deposition;

namespace {

const GridSpec kElevenByNine{11, 9, 0.25, 0.25, 0.0, 0.0};
const DropletModel kInk{4.4e-3, 0.6e-3, 0.2e-3}, kSupport{3.0e-3, 0.9e-3, 0.1e-3};

struct Case {
  HeightMap height{kElevenByNine};
  DropletPattern drops{kElevenByNine};
  OffsetMap offsets{kElevenByNine};
  MaterialMap inks{kElevenByNine};
};

Case random_case(std::uint64_t seed, int places) {
  RandomStream random(seed, Purpose::kPattern);
  Case c;
  for (std::size_t n = 0; n < kElevenByNine.size(); ++n) {
    c.height.cells[n] = 0.02 * random.uniform();
    c.drops.cells[n] = std::uint8_t(random.below(3));
    c.offsets.cells[n] = std::uint8_t(random.below(std::uint32_t(places)));
    c.inks.set(n, random.below(2) ? Material::kA : Material::kB);
  }
  return c;
}

double total_mm(const HeightMap& h) { return std::accumulate(h.cells.begin(), h.cells.end(), 0.0); }

}  // namespace

TEST_CASE("A droplet in the centre changes heights by Lu's (4), with two inks by (7)") {
  for (const Border border : {Border::kLose, Border::kKeep})
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      const OffsetTable table({OffsetKind::kGrid, 4, 4});
      OffsetChange places(kElevenByNine, offset_model(kInk, table), border, offset_model(kSupport, table));
      Case c = random_case(seed, 1);
      HeightMap lu = c.height, two = c.height, lu_placed = c.height, two_placed = c.height;
      HeightChange<1>(kElevenByNine, stencil_of(kInk), border).deposit(lu, c.drops);
      TwoMaterialChange(kElevenByNine, {kInk, kSupport}, border).deposit(two, c.drops, c.inks);
      places.deposit(lu_placed, c.drops, c.offsets);
      places.deposit(two_placed, c.drops, {}, c.inks);
      for (std::size_t n = 0; n < kElevenByNine.size(); ++n) {
        CHECK(lu_placed.cells[n] == Approx(lu.cells[n]).margin(1e-15));
        CHECK(two_placed.cells[n] == Approx(two.cells[n]).margin(1e-15));
      }
    }
}

TEST_CASE("Droplets beside centres add their volume, whatever the ground") {
  const OffsetTable table({OffsetKind::kGrid, 4, 3});
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Case c = random_case(seed, table.size());
    const double before = total_mm(c.height);
    OffsetChange keep(kElevenByNine, offset_model(kInk, table), Border::kKeep);
    HeightMap kept = c.height;
    const Ledger k = keep.deposit(kept, c.drops, c.offsets);
    CHECK(k.drops == c.drops.total());
    CHECK(k.deposited_mm == Approx(double(k.drops) * kInk.layer_height_mm()).epsilon(1e-12));
    CHECK(total_mm(kept) - before == Approx(k.deposited_mm).epsilon(1e-12));
    OffsetChange lose(kElevenByNine, offset_model(kInk, table), Border::kLose);
    HeightMap lost = c.height;
    const Ledger l = lose.deposit(lost, c.drops, c.offsets);
    CHECK(total_mm(lost) - before + l.lost_mm == Approx(l.deposited_mm).epsilon(1e-12));
    CHECK(l.lost_mm > 0.0);
  }
}

TEST_CASE("A cell that stands higher by its share and the droplet's own gets nothing of it") {
  const OffsetTable table({OffsetKind::kX, 4, 1});
  const OffsetModel model = offset_model(kInk, table);
  const int right = table.nearest({0.375, 0.0});
  const OffsetKernel& k = model.kernels[std::size_t(right)];
  DropletPattern drops(kElevenByNine);
  drops.at(5, 4) = 1;
  OffsetMap offsets(kElevenByNine);
  offsets.at(5, 4) = std::uint8_t(right);
  OffsetChange change(kElevenByNine, model, Border::kLose);
  HeightMap flat(kElevenByNine);
  change.deposit(flat, drops, offsets);
  for (int dy = -2; dy <= 2; ++dy)
    for (int dx = -2; dx <= 2; ++dx) CHECK(flat.at(5 + dx, 4 + dy) == Approx(k.at(dx, dy)).margin(1e-15));
  HeightMap wall(kElevenByNine);
  const double w = k.at(1, 0), full = k.at(0, 0) + w;
  wall.at(6, 4) = full;
  change.deposit(wall, drops, offsets);
  CHECK(wall.at(6, 4) == full);
  HeightMap half(kElevenByNine);
  half.at(6, 4) = 0.5 * full;
  change.deposit(half, drops, offsets);
  CHECK(half.at(6, 4) - 0.5 * full == Approx(0.5 * w).margin(1e-15));
}

TEST_CASE("Mixed kernels keep the volume, mirror as their places do, and have their middle at the place") {
  const OffsetTable table({OffsetKind::kGrid, 8, 8});
  for (int n = 0; n < table.size(); ++n) {
    const OffsetKernel k = mixed_kernel(kInk, table[n]),
                       mirrored = mixed_kernel(kInk, {-table[n].x, table[n].y});
    CHECK(k.drop_height_mm() == Approx(kInk.layer_height_mm()).epsilon(1e-12));
    double x = 0.0, y = 0.0;
    for (int dy = -2; dy <= 2; ++dy)
      for (int dx = -2; dx <= 2; ++dx) {
        CHECK(k.at(dx, dy) == Approx(mirrored.at(-dx, dy)).margin(1e-18));
        x += dx * k.at(dx, dy);
        y += dy * k.at(dx, dy);
      }
    CHECK(x / k.drop_height_mm() == Approx(table[n].x).margin(1e-12));
    CHECK(y / k.drop_height_mm() == Approx(table[n].y).margin(1e-12));
  }
}

TEST_CASE("Measured heights of places are taken in their order, and a wrong list is refused by its key") {
  const OffsetTable table({OffsetKind::kX, 2, 1});
  std::vector<double> heights(50, 1e-4);
  heights[OffsetKernel::index(0, 0)] = 3e-3;
  heights[25 + OffsetKernel::index(0, 0)] = 2e-3;
  const OffsetModel m = offset_model(kInk, table, heights);
  CHECK(m.kernels[0] == kernel_of(kInk));
  CHECK(m.kernels[1].at(0, 0) == 3e-3);
  CHECK(m.kernels[2].at(0, 0) == 2e-3);
  heights[30] = -1e-9;
  CHECK_THROWS_WITH(
      offset_model(kInk, table, heights),
      Catch::Contains("actuation.heights_mm") && Catch::Contains("place 2, -1e-09 mm, is outside [0, 10]"));
  heights[30] = 0.0;
  heights[OffsetKernel::index(0, 0)] = 0.0;
  CHECK_THROWS_WITH(offset_model(kInk, table, heights), Catch::Contains("adds nothing to its own cell"));
  heights.pop_back();
  CHECK_THROWS_WITH(offset_model(kInk, table, heights),
                    Catch::Contains("has 49 heights") && Catch::Contains("need 50"));
}
