// The film nature: landing, pinned and advancing contact lines, levelling until the lamp, limits of validity.
#include <catch2/catch.hpp>

#include <cmath>

#include "core/grid/random.h"
#include "plant/inkjet/model.h"

using namespace firn;
using namespace firn::plant;

namespace {

const GridSpec kPlate10{10, 10, 0.263256, 0.263256, 0.0, 0.0};

WorldConfig thin_film(double wet_s = 1.0) {
  WorldConfig c;
  c.model = "thin_film";
  c.grid = kPlate10;
  c.droplet.size_scatter = c.droplet.missed_probability = c.droplet.placement_scatter_mm = 0.0;
  c.nozzle.drift = false;
  c.nature.thin_film.wet_s = wet_s;
  return c;
}

void drop_on(Model& m, int i, int j, std::int64_t t_us = 0) {
  m.fire({t_us, kPlate10.x_mm(i), kPlate10.y_mm(j), 0.0, 0.0});
}

/// A square of 6 x 6 cells with a droplet on each that `pattern` holds.
template <class Pattern>
void print_layer(Model& m, std::int64_t t_us, const Pattern& pattern) {
  for (int j = 2; j < 8; ++j)
    for (int i = 2; i < 8; ++i)
      if (pattern(i, j)) drop_on(m, i, j, t_us += 1000);
  m.end_pass();
  m.expose(t_us + 1'000'000);
  m.measured();
}

double spread_um(const HeightMap& h) {
  double low = 1.0, high = 0.0;
  for (int j = 3; j < 7; ++j)
    for (int i = 3; i < 7; ++i) {
      low = std::min(low, h.at(i, j));
      high = std::max(high, h.at(i, j));
    }
  return 1e3 * (high - low);
}

}  // namespace

TEST_CASE("A thin_film world accounts for every droplet: landed = film + cured + lost + shrunk") {
  WorldConfig c = thin_film(0.2);
  c.droplet.placement_scatter_mm = 0.02;
  const auto model = make_model(c);
  for (int layer = 0; layer < 3; ++layer) {
    drop_on(*model, -2, 4, layer * 10'000'000);  // partly off the field
    drop_on(*model, 30, 4, layer * 10'000'000);
    print_layer(*model, layer * 10'000'000, [](int i, int j) { return (i + j) % 3 != 0; });
  }
  drop_on(*model, 4, 4, 40'000'000);  // still wet
  const VolumeLedger l = model->ledger();
  CHECK(l.lost > 0.0);
  CHECK(model->volume_mm3() + l.lost + l.shrunk == Approx(l.landed).epsilon(1e-10));
}

TEST_CASE("A single droplet spreads until its angle is the advancing one, as wide as Lu measured") {
  const auto model = make_model(thin_film(5.0));
  drop_on(*model, 5, 5);
  model->end_pass();
  model->expose(0);
  const HeightMap fine = model->fine_surface();
  double covered = 0.0, apex = 0.0;
  for (const double h : fine.cells) {
    covered += h > 2e-4;
    apex = std::max(apex, h);
  }
  const double area = covered * fine.spec.pitch_x_mm * fine.spec.pitch_y_mm;
  CHECK(2.0 * std::sqrt(area / 3.14159265) == Approx(0.413).epsilon(0.2));  // cells of 88 um
  CHECK(apex * 1e3 == Approx(7.9).epsilon(0.35));
}

TEST_CASE("The longer a layer stays wet the less of its pattern is left") {
  double before_um = 1e9;
  for (const double wet_s : {0.01, 0.1, 1.0}) {  // after 30 s the island is a dome
    const auto model = make_model(thin_film(wet_s));
    for (int j = 2; j < 8; ++j)
      for (int i = 2; i < 8; ++i)
        if ((i / 2 + j / 2) % 2 == 0) drop_on(*model, i, j);  // beside the layer's own
    print_layer(*model, 0, [](int, int) { return true; });
    const double um = spread_um(model->cell_means());
    CAPTURE(wet_s, um);
    CHECK(um < before_um);
    before_um = um;
  }
}

TEST_CASE("A viscosity four times as high levels in a quarter of the time as much") {
  WorldConfig thick = thin_film(2.0);
  thick.nature.thin_film.viscosity_Pa_s *= 4.0;
  thick.nature.thin_film.gel_s *= 4.0;
  thick.nature.thin_film.group_s = 10.0;
  WorldConfig thin = thin_film(0.5);
  thin.nature.thin_film.group_s = 10.0;
  const auto a = make_model(thick), b = make_model(thin);
  for (const auto& model : {a.get(), b.get()}) {
    for (int n = 0; n < 5; ++n) drop_on(*model, 2 + n, 5);
    model->end_pass();
    model->expose(0);
  }
  const HeightMap of_a = a->cell_means(), of_b = b->cell_means();
  // Contact lines are looked at after 0.02 s, 0.04 s, ... in both.
  for (std::size_t n = 0; n < of_a.size(); ++n) CHECK(of_a.cells[n] == Approx(of_b.cells[n]).margin(4e-4));
}

TEST_CASE("Ink at the rim of a wall stays up on the wall") {
  WorldConfig c = thin_film(1.0);
  const auto model = make_model(c);
  for (int layer = 0; layer < 12; ++layer)
    print_layer(*model, layer * 10'000'000, [](int, int) { return true; });
  const double before_um = 1e3 * model->cell_means().at(9, 5);
  print_layer(*model, 200'000'000, [](int, int) { return true; });
  CHECK(1e3 * model->cell_means().at(4, 4) > 80.0);
  CHECK(1e3 * model->cell_means().at(9, 5) - before_um < 0.05);  // two pitches from the wall
}

TEST_CASE("A film too deep for lubrication theory stops the print by name, value and limit") {
  const auto model = make_model(thin_film());
  CHECK(model->validity().size() == 2);
  for (int n = 0; n < 4; ++n)
    for (int j = 2; j < 8; ++j)
      for (int i = 2; i < 8; ++i) drop_on(*model, i, j);
  model->end_pass();
  CHECK_THROWS_WITH(model->expose(0),
                    Catch::Contains("times film thickness has reached") && Catch::Contains("used up to 0.5"));
}

TEST_CASE("The values of a thin film's validity are within their limits after a layer") {
  const auto model = make_model(thin_film());
  print_layer(*model, 0, [](int, int) { return true; });
  const std::vector<Validity> v = model->validity();
  for (const Validity& one : v) CHECK((one.reached > 0.0 && one.reached < one.most));
  CHECK(v[1].reached == Approx(2 * 3.14159265 / 0.263256 * 0.0076 / 0.98).epsilon(0.5));
}

TEST_CASE("A thin_film world goes on from its saved state as if it had not stopped") {
  const auto whole = make_model(thin_film(0.1)), first = make_model(thin_film(0.1)),
             second = make_model(thin_film(0.1));
  const auto even = [](int i, int j) { return (i + j) % 2 == 0; };
  print_layer(*whole, 0, even);
  print_layer(*first, 0, even);
  drop_on(*whole, 4, 4, 5'000'000);
  drop_on(*first, 4, 4, 5'000'000);
  Archive saved;
  first->io(saved);
  Archive loaded(saved.bytes());
  second->io(loaded);
  loaded.expect_end();
  print_layer(*whole, 6'000'000, even);
  print_layer(*second, 6'000'000, even);
  CHECK(second->fine_surface().cells == whole->fine_surface().cells);
}
