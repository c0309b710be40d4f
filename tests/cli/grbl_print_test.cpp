// Whole prints on a simulated GRBL board, beside those on the Ensemble.
#include <catch2/catch.hpp>

#include "config/include.h"
#include "print/labs/full_product.h"
#include "print/simulated/memory_print.h"

namespace firn {
namespace {

Experiment grbl_part(const char* lab, const std::string& scheme) {
  return load_experiment(
      FIRN_SOURCE_DIR "/experiments/cuboid.toml",
      {"grid.nx=14", "grid.ny=12", "part.width_mm=2.6", "part.depth_mm=2.1", "part.height_mm=0.04",
       "control.scheme=\"" + scheme + "\"", std::string("devices.stage.kind=\"") + lab + "\"",
       "stage.counts_per_mm=250.0", "stage.acceleration_mm_s2=500.0", "stage.max_speed_mm_s=60.0",
       "stage.laser_output=\"on\"", "stage.scan_box=\"on\"", "process.pass_speed_mm_s=15.0",
       "process.scan_speed_mm_s=10.0"});
}

MemoryPrintReport print_on(const char* stage, const std::string& scheme) {
  const Experiment e = grbl_part(stage, scheme);
  MemoryPrintOptions options;
  options.surface = true;
  return print_in_memory(full_product(), e, make_inputs(full_product(), e, ""), options);
}

}  // namespace

TEST_CASE("a GRBL board fires the droplets of an open-loop print that the Ensemble fires", "[grbl]") {
  const MemoryPrintReport grbl = print_on("grbl", "open_loop"), ensemble = print_on("ensemble", "open_loop");
  INFO(grbl.result.reason);
  REQUIRE(grbl.result.status == 0);
  REQUIRE(ensemble.result.status == 0);
  CHECK(grbl.droplets == ensemble.droplets);
  // A droplet comes up to half a step of 1/250 mm elsewhere, so another share of it lies beside the field.
  CHECK(grbl.volume_mm3 == Approx(ensemble.volume_mm3).epsilon(1e-3));
}

TEST_CASE("a closed-loop print on a GRBL board is as accurate as on the Ensemble", "[grbl]") {
  const MemoryPrintReport grbl = print_on("grbl", "smf"), ensemble = print_on("ensemble", "smf");
  INFO(grbl.result.reason);
  REQUIRE(grbl.result.status == 0);
  CHECK(grbl.error.rms_mm == Approx(ensemble.error.rms_mm).epsilon(0.1));
}

}  // namespace firn
