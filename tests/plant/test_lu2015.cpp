#include <catch2/catch.hpp>

#include "core/deposition/height_change.h"
#include "core/grid/random.h"
#include "plant/inkjet/model.h"
#include "plant/inkjet/sensor.h"

using namespace firn;
using namespace firn::plant;

TEST_CASE("lu2015 without variation is Eq. (4) pass by pass, however its droplets arrive") {
  WorldConfig c;
  c.model = "lu2015";
  c.grid = {12, 10, 0.263256, 0.263256, 0.0, 0.0};
  c.lu2015.variation = 0.0;
  const auto model = make_model(c);
  deposition::HeightChange<1> eq4(c.grid, deposition::stencil_of({}), deposition::Border::kLose);
  HeightMap expected(c.grid, 0.0);
  RandomStream random(2, Purpose::kTest);
  for (int layer = 0; layer < 8; ++layer) {
    DropletPattern drops(c.grid);
    for (auto& d : drops.cells) d = std::uint8_t(random.below(3));
    for (int pass = 0; pass < drops.passes(); ++pass) {
      for (int j = 0; j < c.grid.ny; ++j)
        for (int i = c.grid.nx - 1; i >= 0; --i)
          if (drops.at(i, j) > pass) model->fire({0, c.grid.x_mm(i), c.grid.y_mm(j), 0.0, 0.0});
      if (layer % 2 == 0) model->end_pass();  // else the next droplet on a cell, or the lamp, ends it
      eq4.step(expected.data(), drops.data(), pass);
      if (layer % 2 == 1) model->end_pass();
    }
    CHECK(model->cell_means().cells == expected.cells);
    model->expose(layer);
  }
  CHECK(model->layers().exposures() == 8);
  const VolumeLedger l = model->ledger();
  CHECK(l.landed - l.lost == Approx(model->volume_mm3()).epsilon(1e-12));
}

TEST_CASE("lu2015 scales h1, h2, h3 upward by at most v, per droplet and layer (errata, FIT)") {
  WorldConfig c;
  c.model = "lu2015";
  c.lu2015.variation = 0.4;
  const auto model = make_model(c);
  const double nominal = 0.0076 * 0.263256 * 0.263256;
  double sum = 0.0;
  for (int i = 0; i < 40; ++i)
    for (int j = 0; j < 40; ++j) {
      const double v = model->fire({0, c.grid.x_mm(i), c.grid.y_mm(j), 0.0, 0.0}).volume_mm3 / nominal - 1.0;
      CHECK((v >= -1e-12 && v <= 0.4 + 1e-12));
      sum += v;
    }
  CHECK(sum / 1600 == Approx(0.2).epsilon(0.05));
}

TEST_CASE("The sensor sees a lu2015 cell as one height and settles a pass before it looks") {
  WorldConfig c;
  c.model = "lu2015";
  c.grid = {6, 6, 0.25, 0.25, 0.0, 0.0};
  c.lu2015.variation = 0.0;
  c.sensor.noise_mm = c.sensor.dropout_floor = 0.0;
  const auto model = make_model(c);
  model->fire({0, 0.5, 0.5, 0.0, 0.0});
  std::vector<double> z(3);
  measure_profile(model->surface(), c.sensor, {}, 0.5, 0.4, 0.05, z);
  for (const double v : z) CHECK(v == Approx(0.0044).epsilon(1e-12));
}
