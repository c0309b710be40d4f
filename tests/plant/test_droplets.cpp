#include <catch2/catch.hpp>

#include <cmath>

#include "plant/inkjet/model.h"
#include "plant/inkjet/nozzle.h"

using namespace firn;
using namespace firn::plant;

namespace {

WorldConfig droplet_world(std::uint64_t seed = 3) {
  WorldConfig c;
  c.grid = {16, 16, 0.263256, 0.263256, 0.0, 0.0};
  c.seed = seed;
  return c;
}

Shot at_cell(const GridSpec& g, int i, int j, std::int64_t t_us) {
  return {t_us, g.x_mm(i), g.y_mm(j), 0.0, 0.0};
}

// Steady 400 droplets a second for `seconds`, against the closed form of the linear states.
NozzleState after(double seconds, const NozzleParams& p) {
  Nozzle nozzle(p, 1);
  std::int64_t t = 0;
  for (; t <= std::int64_t(seconds * 1e6); t += 2500) nozzle.fire(t);
  nozzle.cured(std::int64_t(seconds * 1e6), 1);
  return nozzle.state();
}

}  // namespace

TEST_CASE("The same droplet sees the same disturbance whatever was printed before it") {
  WorldConfig c = droplet_world();
  c.nozzle.drift = false;
  const auto a = make_model(c), b = make_model(c);
  for (int n = 0; n < 50; ++n) a->fire(at_cell(c.grid, 2 + n % 10, 3, n));  // only in the first world
  for (const auto& model : {a.get(), b.get()}) model->expose(1'000'000);
  const Landing la = a->fire(at_cell(c.grid, 8, 9, 2'000'000)),
                lb = b->fire(at_cell(c.grid, 8, 9, 7'000'000));
  CHECK(la.volume_mm3 == lb.volume_mm3);
  CHECK(la.x_mm == lb.x_mm);
  CHECK(la.y_mm == lb.y_mm);
  const Landing second = b->fire(at_cell(c.grid, 8, 9, 7'000'001));
  CHECK(second.volume_mm3 != lb.volume_mm3);
}

TEST_CASE("A droplet of another pulse has its share of the volume and meets the ground at the same angle") {
  WorldConfig c = droplet_world();
  c.nozzle.drift = false;
  c.droplet.size_scatter = c.droplet.placement_scatter_mm = 0.0;
  c.droplet.missed_probability = c.droplet.satellite_probability = 0.0;
  const double share = 0.6;
  const auto by_pulse = make_model(c);
  Shot shot = at_cell(c.grid, 8, 8, 0);
  shot.volume_share = share;
  CHECK(by_pulse->fire(shot).volume_mm3 == Approx(share * c.droplet.volume_mm3));
  c.droplet.flow = share;  // the same droplet from a printer of smaller ones
  c.droplet.radius_exponent = 1.0 / 3.0;
  const auto by_flow = make_model(c);
  by_flow->fire(at_cell(c.grid, 8, 8, 0));
  const HeightMap a = by_pulse->fine_surface(), b = by_flow->fine_surface();
  for (std::size_t n = 0; n < a.size(); ++n) CHECK(a.cells[n] == Approx(b.cells[n]).margin(1e-12));
}

TEST_CASE("Droplet sizes, places and misses have the configured statistics") {
  WorldConfig c = droplet_world();
  c.nozzle.drift = false;
  c.droplet.missed_probability = 0.02;
  c.droplet.satellite_probability = 0.0;
  const auto model = make_model(c);
  double sum = 0, square = 0, place = 0;
  int missed = 0, landed = 0;
  for (int layer = 0; layer < 100; ++layer) {
    for (int j = 0; j < 16; ++j)
      for (int i = 0; i < 16; ++i) {
        const Landing l = model->fire(at_cell(c.grid, i, j, layer));
        if (l.missed) {
          ++missed;
          continue;
        }
        const double v = l.volume_mm3 / c.droplet.volume_mm3 - 1.0;
        ++landed;
        sum += v;
        square += v * v;
        place += (l.x_mm - c.grid.x_mm(i)) * (l.x_mm - c.grid.x_mm(i));
      }
    model->expose(layer);
  }
  CHECK(std::abs(sum / landed) < 4 * 0.03 / std::sqrt(landed));
  CHECK(std::sqrt(square / landed) == Approx(0.03).epsilon(0.03));
  CHECK(std::sqrt(place / landed) == Approx(c.droplet.placement_scatter_mm).epsilon(0.03));
  CHECK(missed / 25600.0 == Approx(0.02).epsilon(0.2));
}

TEST_CASE("No droplet reaches a dead row, and every other row is as without it") {
  WorldConfig c = droplet_world();
  const auto whole = make_model(c);
  c.droplet.dead_row = 6;
  const auto clogged = make_model(c);
  for (int j = 4; j < 9; ++j) {
    const Landing a = whole->fire(at_cell(c.grid, 5, j, 1000 * j)),
                  b = clogged->fire(at_cell(c.grid, 5, j, 1000 * j));
    CHECK(b.missed == (j == 6));
    if (j != 6) CHECK(a.x_mm == b.x_mm);
  }
}

TEST_CASE("An ink of another flow and spread lands the same volume times the flow, over the spread's area") {
  const auto landed = [](double flow, double spread) {
    WorldConfig c = droplet_world();
    c.nozzle.drift = false;
    c.droplet.size_scatter = c.droplet.placement_scatter_mm = c.droplet.missed_probability =
        c.droplet.satellite_probability = 0.0;
    c.droplet.levelling_steps = 0;
    c.droplet.flow = flow;
    c.droplet.spread = spread;
    const auto model = make_model(c);
    const double volume_mm3 = model->fire(at_cell(c.grid, 8, 8, 0)).volume_mm3;
    const HeightMap h = model->cell_means();
    double moment = 0.0, sum = 0.0;
    for (int j = 0; j < 16; ++j)
      for (int i = 0; i < 16; ++i) {
        moment += h.at(i, j) * (i - 8) * (i - 8);
        sum += h.at(i, j);
      }
    CHECK(sum * c.grid.pitch_x_mm * c.grid.pitch_y_mm == Approx(volume_mm3).epsilon(1e-12));
    return std::pair{volume_mm3, moment / sum};
  };
  const auto [volume, moment] = landed(1.0, 1.0);
  CHECK(volume == Approx(DropletParams{}.volume_mm3));
  CHECK(landed(0.7, 1.0).first == Approx(0.7 * volume));
  CHECK(landed(0.7, 1.0).second == Approx(moment).epsilon(0.02));
  CHECK(landed(1.0, 1.4).first == Approx(volume));
  CHECK(landed(1.0, 1.4).second > 1.4 * moment);
  CHECK(landed(1.0, 0.8).second < 0.8 * moment);
}

TEST_CASE("A droplet of the measured width lies within it, and grows with the cube root of its volume") {
  // Radius of gyration of a paraboloid of revolution about its axis: R / sqrt(3).
  const auto radius_mm = [](double flow) {
    WorldConfig c = droplet_world();
    c.droplet = droplet413();
    c.nozzle.drift = false;
    c.droplet.size_scatter = c.droplet.placement_scatter_mm = c.droplet.missed_probability =
        c.droplet.satellite_probability = 0.0;
    c.droplet.levelling_steps = 0;
    c.droplet.fine_cells = 8;
    c.droplet.slope_bias_mm = 1e6;
    c.droplet.flow = flow;
    const auto model = make_model(c);
    model->fire(at_cell(c.grid, 8, 8, 0));
    const HeightMap h = model->fine_surface();
    double moment = 0.0, sum = 0.0;
    for (int j = 0; j < h.spec.ny; ++j)
      for (int i = 0; i < h.spec.nx; ++i) {
        const double r = std::hypot(h.spec.x_mm(i) - c.grid.x_mm(8), h.spec.y_mm(j) - c.grid.y_mm(8));
        if (r > 0.2065 * std::cbrt(flow) + 1e-9) CHECK(h.at(i, j) == 0.0);
        moment += h.at(i, j) * r * r;
        sum += h.at(i, j);
      }
    return std::sqrt(3.0 * moment / sum);
  };
  CHECK(radius_mm(1.0) == Approx(0.2065).epsilon(0.02));
  CHECK(radius_mm(1.728) == Approx(1.2 * 0.2065).epsilon(0.02));
}

TEST_CASE("CVODE's line states agree with their closed forms at a steady firing rate") {
  NozzleParams p;
  p.wander_sigma = 0.0;
  const double f = 400.0, t = 60.0;
  const NozzleState s = after(t, p);
  CHECK(s.pressure ==
        Approx(-p.pressure_per_drop * f * p.pressure_tau_s * (1 - std::exp(-t / p.pressure_tau_s)))
            .epsilon(1e-3));
  CHECK(s.heating_K ==
        Approx(p.heating_per_drop_K * f * p.heating_tau_s * (1 - std::exp(-t / p.heating_tau_s)))
            .epsilon(1e-3));
  const double rate = p.wetting_per_drop * f + 1.0 / p.wetting_tau_s;
  CHECK(s.wetting == Approx(p.wetting_per_drop * f / rate * (1 - std::exp(-rate * t))).epsilon(1e-3));
}

TEST_CASE("A restored model goes on bit for bit") {
  for (const char* name : {"droplets", "lu2015"}) {
    WorldConfig c = droplet_world();
    c.model = name;
    const auto a = make_model(c);
    std::int64_t t = 0;
    for (int n = 0; n < 500; ++n) a->fire(at_cell(c.grid, n % 16, n / 16 % 16, t += 30'000));
    a->expose(t);
    for (int n = 0; n < 37; ++n) a->fire(at_cell(c.grid, n % 16, n / 16, t += 30'000));
    Archive saved;
    a->io(saved);
    const auto b = make_model(c);
    Archive loaded(saved.bytes());
    b->io(loaded);
    loaded.expect_end();
    for (int n = 37; n < 300; ++n) {
      const Shot shot = at_cell(c.grid, n % 16, n / 16 % 16, t += 30'000);
      CHECK(a->fire(shot).volume_mm3 == b->fire(shot).volume_mm3);
    }
    a->expose(t);
    b->expose(t);
    CHECK(a->cell_means().cells == b->cell_means().cells);
    CHECK(a->layers().exposures() == 2);
  }
}

TEST_CASE("A world that cannot be is refused by field and limit") {
  WorldConfig c = droplet_world();
  c.model = "wax";
  CHECK_THROWS_WITH(make_model(c), Catch::Contains("wax") && Catch::Contains("lu2015"));
  c = droplet_world();
  c.droplet.run_share = 0.3;
  CHECK_THROWS_WITH(make_model(c), Catch::Contains("run_share") && Catch::Contains("0.25"));
}
