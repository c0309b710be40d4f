// Blocks of two inks and registration prints, whole, in simulated time.
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>

#include "cli/calibrate_command.h"
#include "config/include.h"
#include "files/usage_error.h"
#include "print/labs/full_product.h"
#include "print/simulated/lab_run.h"
#include "print/simulated/memory_print.h"
#include "runs/folder/run_folder.h"
#include "tests/support/temp_folder.h"

namespace firn {
namespace {

Experiment block(const std::string& plant) {
  Experiment e;
  e.grid = {14, 12, 0.263256, 0.263256, 0.0, 0.0};
  e.part.shape.kind = "cuboid";
  e.part.shape.width_mm = 3.6;
  e.part.shape.depth_mm = 3.1;
  e.part.shape.height_mm = 0.04;
  e.geometry.solid.kind = "pipe";
  e.geometry.solid.outer_diameter_mm = 2.6;
  e.geometry.solid.inner_diameter_mm = 1.0;
  e.control.scheme = "mpc";
  e.plant.model = plant;
  return e;
}

MemoryPrintReport print(const Experiment& e) {
  MemoryPrintOptions options;
  options.surface = options.materials = true;
  return print_in_memory(full_product(), e, make_inputs(full_product(), e, ""), options);
}

// Cells whose column is for the larger part of another ink than the (upright) pipe wants.
int wrong_cells(const Experiment& e, const MaterialColumns& printed) {
  const double cx = 0.5 * (e.grid.x_mm(0) + e.grid.x_mm(e.grid.nx - 1)),
               cy = 0.5 * (e.grid.y_mm(0) + e.grid.y_mm(e.grid.ny - 1));
  int wrong = 0;
  for (int j = 1; j + 1 < e.grid.ny; ++j)
    for (int i = 1; i + 1 < e.grid.nx; ++i) {
      const double r = std::hypot(e.grid.x_mm(i) - cx, e.grid.y_mm(j) - cy);
      const Material wanted = r < 1.3 && r > 0.5 ? Material::kA : Material::kB;
      wrong += printed.most(e.grid.index(i, j), 0.0, printed.top_mm(e.grid.index(i, j))) != wanted;
    }
  return wrong;
}

TEST_CASE("two inks: each column is as high as its cell, and made of the ink that the geometry wants") {
  for (const char* plant : {"droplets", "lu2015"})
    for (const int sub_patterns : {1, 4}) {
      CAPTURE(plant, sub_patterns);
      Experiment e = block(plant);
      e.process.sub_patterns = sub_patterns;
      const MemoryPrintReport r = print(e);
      REQUIRE(r.result.status == 0);
      REQUIRE_FALSE(r.materials.empty());
      for (std::size_t c = 0; c < e.grid.size(); ++c)
        CHECK(r.materials.top_mm(c) == Approx(r.surface.cells[c]).margin(2e-4));
      CHECK(wrong_cells(e, r.materials) == 0);
    }
}

TEST_CASE("a second nozzle that stands elsewhere than believed prints its ink in the wrong cells") {
  Experiment e = block("droplets");
  e.plant.nozzle_b_x_mm = e.jet_b.offset_x_mm + 2.0 * e.grid.pitch_x_mm;
  const MemoryPrintReport off = print(e);
  CHECK(wrong_cells(e, off.materials) >= 5);
  e.jet_b.offset_x_mm = e.plant.nozzle_b_x_mm;  // calibrated
  CHECK(wrong_cells(e, print(e).materials) == 0);
}

TEST_CASE("a droplet of ink B has its own volume, whatever the controller believes") {
  Experiment e = block("lu2015");
  e.control.scheme = "open_loop";
  e.control.open_loop.layers = 3;
  e.plant.variation = 0.0;
  const double one = print(e).volume_mm3;
  e.plant.ratio_b = 0.5;
  const double half = print(e).volume_mm3;
  CHECK(half < 0.85 * one);
  CHECK(half > 0.5 * one);
}

TEST_CASE(
    "firn calibrate finds the planted offset of the second nozzle, and what it proposes is right when "
    "taken") {
  const test::TempFolder folder;
  Experiment e = load_experiment(FIRN_SOURCE_DIR "/experiments/registration.toml", {});
  for (const auto& [dx, dy] : {std::pair(0.083, -0.041), std::pair(-0.31, 0.22)}) {
    CAPTURE(dx, dy);
    e.plant.seed += 1;
    e.plant.nozzle_b_x_mm = 20.0 + dx;
    e.plant.nozzle_b_y_mm = dy;
    const runs::RunFolder run =
        runs::RunFolder::create(folder.path(), e, make_inputs(full_product(), e, ""), {"test"});
    REQUIRE(run_in_lab(full_product(), run, {}).result.status == 0);
    const Calibration c = calibrate(run.path());
    CHECK(std::abs(c.offset_x_mm() - e.plant.nozzle_b_x_mm) < 4.0 * c.off.x.sigma_mm);
    CHECK(std::abs(c.offset_y_mm() - e.plant.nozzle_b_y_mm) < 4.0 * c.off.y.sigma_mm);
    CHECK(c.off.x.sigma_mm < 0.006);

    const Experiment lab = parse_experiment(proposal(c, "test"), "jet_b.toml");
    CHECK(lab.jet_b.offset_x_mm == Approx(c.offset_x_mm()).margin(1e-5));
    CHECK(lab.jet_b.offset_y_mm == Approx(c.offset_y_mm()).margin(1e-5));
    CalibrateOptions options;
    options.run = run.path().string();
    options.output = (folder.path() / "proposal.toml").string();
    options.json = true;
    CHECK(run_calibrate(options) == 0);
    CHECK(std::filesystem::exists(folder.path() / "proposal.toml"));
  }
}

TEST_CASE("firn calibrate refuses another print, and marks that are too far off, by name") {
  const test::TempFolder folder;
  Experiment e = block("lu2015");
  e.control.max_layers = 1;
  const runs::RunFolder other =
      runs::RunFolder::create(folder.path(), e, make_inputs(full_product(), e, ""), {"test"});
  run_in_lab(full_product(), other, {});
  CHECK_THROWS_WITH(calibrate(other.path()), Catch::Contains("no registration print"));
  CHECK_THROWS_AS(calibrate(folder.path() / "none"), std::exception);

  Experiment far = load_experiment(FIRN_SOURCE_DIR "/experiments/registration.toml", {});
  far.plant.nozzle_b_x_mm = 20.75;
  const runs::RunFolder run =
      runs::RunFolder::create(folder.path(), far, make_inputs(full_product(), far, ""), {"test"});
  run_in_lab(full_product(), run, {});
  CHECK_THROWS_WITH(calibrate(run.path()), Catch::Contains("marks of nozzle B are not within"));
}

}  // namespace
}  // namespace firn
