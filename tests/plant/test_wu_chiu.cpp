// The nature after Wu and Chiu: volume, area, and its special point, at which it is Lu's law.
#include <catch2/catch.hpp>

#include "core/deposition/height_change.h"
#include "core/grid/random.h"
#include "plant/inkjet/model.h"

using namespace firn;
using namespace firn::plant;

namespace {

const GridSpec kCells{12, 10, 0.263256, 0.263256, 0.0, 0.0};

WorldConfig wu_chiu() {
  WorldConfig c;
  c.model = "wu_chiu";
  c.grid = kCells;
  c.droplet.size_scatter = c.droplet.missed_probability = 0.0;
  c.nozzle.drift = false;
  return c;
}

/// h1 to h3 of [Lu 2015, Table I] as shares and slopes.
WorldConfig special_point() {
  WorldConfig c = wu_chiu();
  const double h1 = 4.4e-3, h2 = 0.6e-3, h3 = 0.2e-3, whole = h1 + 4 * h2 + 4 * h3;
  c.droplet.volume_mm3 = whole * kCells.pitch_x_mm * kCells.pitch_y_mm;
  c.droplet.cure_shrink = 0.0;
  c.nature.wu_chiu = {h2 / whole, h3 / whole, 1.0 / (h1 + h2), 1.0 / (h1 + h3), 0.0, 0.0, 1.0, 1.0};
  return c;
}

void drop(Model& model, int i, int j) { model.fire({0, kCells.x_mm(i), kCells.y_mm(j), 0.0, 0.0}); }

double largest_difference(const HeightMap& a, const HeightMap& b) {
  double most = 0.0;
  for (std::size_t n = 0; n < a.size(); ++n) most = std::max(most, std::abs(a.cells[n] - b.cells[n]));
  return most;
}

}  // namespace

TEST_CASE("wu_chiu at its special point is Eq. (4) of Lu, pass by pass") {
  WorldConfig c = special_point();
  c.nature.wu_chiu.order = FlowOrder::kPass;
  const auto model = make_model(c);
  deposition::HeightChange<1> eq4(kCells, deposition::stencil_of({}), deposition::Border::kLose);
  HeightMap expected(kCells, 0.0);
  RandomStream random(2, Purpose::kTest);
  for (int layer = 0; layer < 8; ++layer) {
    DropletPattern drops(kCells);
    for (auto& d : drops.cells) d = std::uint8_t(random.below(3));
    for (int pass = 0; pass < drops.passes(); ++pass) {
      for (int j = 0; j < kCells.ny; ++j)
        for (int i = 0; i < kCells.nx; ++i)
          if (drops.at(i, j) > pass) drop(*model, i, j);
      model->end_pass();
      eq4.step(expected.data(), drops.data(), pass);
    }
    CHECK(largest_difference(model->cell_means(), expected) < 1e-15 * 100);
    model->expose(layer);
  }
}

TEST_CASE("wu_chiu at its special point is Eq. (5) of Lu, droplet by droplet") {
  const auto model = make_model(special_point());
  deposition::HeightChange<1> eq5(kCells, deposition::stencil_of({}), deposition::Border::kLose);
  HeightMap expected(kCells, 0.0);
  RandomStream random(3, Purpose::kTest);
  for (int n = 0; n < 600; ++n) {
    const int i = int(random.below(12)), j = int(random.below(10));
    drop(*model, i, j);
    DropletPattern one(kCells);
    one.at(i, j) = 1;
    eq5.step(expected.data(), one.data(), 0);
  }
  CHECK(largest_difference(model->cell_means(), expected) < 1e-13);
}

TEST_CASE("wu_chiu away from that point is another law") {
  WorldConfig lower = special_point();
  lower.nature.wu_chiu.lower_side_per_mm = 40.0;
  lower.nature.wu_chiu.most_share = 2.0;
  const auto a = make_model(special_point()), b = make_model(lower);
  for (const auto& model : {a.get(), b.get()})
    for (int n = 0; n < 5; ++n) drop(*model, 5, 5);
  CHECK(b->cell_means().at(6, 5) > 1.2 * a->cell_means().at(6, 5));  // low ground gets more
  CHECK(b->cell_means().at(5, 5) < a->cell_means().at(5, 5));
}

TEST_CASE("wu_chiu keeps every droplet's volume, whatever its coefficients") {
  RandomStream random(4, Purpose::kTest);
  for (int draw = 0; draw < 20; ++draw) {
    WorldConfig c = wu_chiu();
    c.nature.wu_chiu = {0.2 * random.uniform(),
                        0.04 * random.uniform(),
                        300.0 * random.uniform(),
                        300.0 * random.uniform(),
                        300.0 * random.uniform(),
                        300.0 * random.uniform(),
                        1.0 + 3.0 * random.uniform(),
                        0.05 + 0.95 * random.uniform(),
                        random.uniform(),
                        random.uniform(),
                        random.uniform(),
                        draw % 2 ? FlowOrder::kPass : FlowOrder::kDrop};
    const auto model = make_model(c);
    for (int n = 0; n < 1000; ++n) drop(*model, int(random.below(14)) - 1, int(random.below(12)) - 1);
    const VolumeLedger l = model->ledger();
    CHECK(model->volume_mm3() == Approx(l.landed - l.lost - l.shrunk).epsilon(1e-12));
    for (const double h : model->cell_means().cells) CHECK((h >= 0.0 && h < 10.0));
  }
}

TEST_CASE("A column that covers less of its cell is as much higher, until it covers the cell") {
  WorldConfig c = special_point();
  c.nature.wu_chiu.least_cover = 0.25;
  c.nature.wu_chiu.cover = 0.25;
  c.nature.wu_chiu.cover_side = c.nature.wu_chiu.cover_corner = 0.0;
  c.nature.wu_chiu.side_share = c.nature.wu_chiu.corner_share = 0.0;
  const auto model = make_model(c);
  for (const double expected_um : {4 * 7.6, 4 * 7.6, 4 * 7.6, 4 * 7.6, 5 * 7.6, 6 * 7.6}) {
    drop(*model, 5, 5);
    CHECK(model->cell_means().at(5, 5) * 1e3 == Approx(expected_um).epsilon(1e-12));
  }
}

TEST_CASE("A wu_chiu world goes on from its saved state as if it had not stopped") {
  WorldConfig c = wu_chiu();
  c.droplet.size_scatter = 0.05;
  const auto whole = make_model(c), first = make_model(c), second = make_model(c);
  const auto print = [](Model& m, int from, int to) {
    for (int layer = from; layer < to; ++layer) {
      for (int n = 0; n < 60; ++n) drop(m, (7 * n + layer) % 12, n % 10);
      m.end_pass();
      m.expose(layer * 1'000'000);
      m.measured();
    }
  };
  print(*whole, 0, 6);
  print(*first, 0, 3);
  Archive saved;
  first->io(saved);
  Archive loaded(saved.bytes());
  second->io(loaded);
  loaded.expect_end();
  print(*second, 3, 6);
  CHECK(second->cell_means().cells == whole->cell_means().cells);
}
