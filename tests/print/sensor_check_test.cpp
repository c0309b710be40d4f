// Sensors and nozzles that are not where or what the lab believes: named, then stopped, before a scheme
// answers their maps. Prints that are as calibrated meet no such warning.
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "config/include.h"
#include "files/exit_codes.h"
#include "firn/fault_t.hpp"
#include "print/labs/full_product.h"
#include "print/simulated/memory_print.h"
#include "tests/print/ice_runs.h"

using namespace firn;
using Catch::Matchers::Contains;
using firn::test::small_ice_part;

namespace {

constexpr int kSensor = 15;  // interlock

struct Printed {
  MemoryPrintReport report;
  std::vector<std::string> warnings, stops;  // of the interlock
};

Printed printed(const Experiment& e, const Blobs& inputs) {
  Printed p;
  MemoryPrintOptions o;
  o.tap = [&](std::string_view channel, std::span<const std::byte> bytes) {
    fault_t f{};
    if (channel != "FAULT_SCHEDULER" || f.decode(bytes.data(), 0, int(bytes.size())) < 0 || f.code != kSensor)
      return;
    (Severity(f.severity) == Severity::kStop ? p.stops : p.warnings).push_back(f.text);
  };
  p.report = print_in_memory(full_product(), e, inputs, o);
  return p;
}

Printed ice(std::vector<std::string> overrides) {
  const auto s = small_ice_part(overrides);
  return printed(s.experiment, s.inputs);
}

Printed inkjet(std::vector<std::string> overrides) {
  const std::filesystem::path folder = std::filesystem::path(FIRN_SOURCE_DIR) / "experiments";
  for (const char* small : {"part.height_mm=0.04", "grid.nx=24", "grid.ny=24", "part.diameter_mm=5"})
    overrides.insert(overrides.begin(), small);
  const Experiment e = load_experiment(folder / "cylinder.toml", overrides);
  return printed(e, make_inputs(full_product(), e, folder));
}

void check_named(const Printed& p, const std::string& what, const std::string& calibrate) {
  REQUIRE(p.stops.size() == 1);
  CHECK(p.warnings.size() == 1);
  CHECK(p.report.result.status == kSafetyStop);
  CHECK_THAT(p.stops.front(), Contains(what) && Contains(calibrate));
  CHECK_THAT(p.warnings.front(), Contains(what) && Contains("measuring again"));
}

}  // namespace

TEST_CASE("A point laser that reads 0.3 mm high or low is found on the bare table, before anything is laid",
          "[I15]") {
  for (const char* dz : {"0.3", "-0.3"}) {
    CAPTURE(dz);
    const Printed p = ice({"ice.map_table=on", std::string("plant.ice.laser_dz_mm=") + dz});
    check_named(p, "the bare table measures", "firn calibrate laser-offset");
    CHECK(p.report.droplets == 0);
  }
}

TEST_CASE("Without a map of the table a point laser 0.3 mm off is a warning that names the way to tell") {
  const Printed p = ice({"plant.ice.laser_dz_mm=0.3"});
  REQUIRE(p.warnings.size() == 1);
  CHECK_THAT(p.warnings.front(), Contains("the first interval") && Contains("ice.map_table = \"on\""));
  CHECK(p.stops.empty());
}

TEST_CASE("A point laser or a nozzle 2 mm aside is found at the first interval, in any direction") {
  for (const char* key : {"plant.ice.laser_dx_mm", "plant.ice.laser_dy_mm", "plant.ice.valve_a_dx_mm",
                          "plant.ice.valve_a_dy_mm"})
    for (const char* off : {"2.0", "-2.0"})
      for (const char* table : {"on", "off"}) {
        CAPTURE(key, off, table);
        const Printed p =
            ice({std::string(key) + "=" + off, std::string("ice.map_table=") + table, "control.scheme=smf"});
        check_named(p, "aside of its outline", "firn calibrate laser-offset");
      }
}

TEST_CASE("An ice print as calibrated meets no such warning, whatever the day and the valves' drift") {
  for (int seed = 1; seed <= 12; ++seed) {
    CAPTURE(seed);
    std::vector<std::string> day{"plant.seed=" + std::to_string(seed)};
    if (seed % 2)  // the table's map tells its unevenness and a valve's flow from the laser
      day.insert(day.end(), {"ice.map_table=on", "plant.ice.drift_spread=0.2"});
    const Printed p = ice(day);
    CHECK(p.warnings.empty());
    CHECK(p.stops.empty());
    CHECK(p.report.result.status == 0);
  }
}

TEST_CASE("A profiler with a bias is found on the bare table, one aside at the first layer", "[I15]") {
  for (const char* dz : {"0.02", "-0.02"}) {
    const Printed p = inkjet({std::string("plant.profiler_dz_mm=") + dz});
    check_named(p, "the bare table measures", "zero");
    CHECK(p.report.droplets == 0);
  }
  for (const char* key : {"plant.profiler_dx_mm", "plant.profiler_dy_mm"})
    for (const char* off : {"0.5", "-0.5", "2.0", "-2.0"}) {
      CAPTURE(key, off);
      check_named(inkjet({std::string(key) + "=" + off}), "the first layer lies",
                  "laser_profiler.offset_y_mm");
    }
}

TEST_CASE("An ink-jet print as calibrated meets no such warning, for any scheme, seed, part and nature") {
  for (int seed = 1; seed <= 6; ++seed)
    for (const char* scheme : {"mpc", "smf", "threshold", "open_loop"})
      for (const char* plant : {"droplets", "lu2015"}) {
        CAPTURE(seed, scheme, plant);
        const Printed p = inkjet(
            {"plant.seed=" + std::to_string(seed), std::string("control.scheme=") + scheme,
             std::string("plant.model=") + plant, seed % 2 ? "part.shape=cone" : "part.shape=cylinder"});
        CHECK(p.warnings.empty());
        CHECK(p.stops.empty());
        CHECK(p.report.result.status == 0);
      }
}
