#include "config/aerosol_lab.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "config/error.h"
#include "config/include.h"
#include "config/labs.h"

using namespace firn;
using Catch::Contains;

namespace {

const std::filesystem::path kMeander = FIRN_SOURCE_DIR "/experiments/aerosol-meander.toml";

Experiment meander(const std::vector<std::string>& overrides = {}) {
  return load_experiment(kMeander, overrides);
}

}  // namespace

TEST_CASE("The aerosol lab names the file that it needs where the experiment has none") {
  CHECK_THROWS_WITH(meander({"aerosol.job=''"}), Contains("aerosol.job") && Contains("needs this file"));
  CHECK_THROWS_WITH(meander({"aerosol.machine=''"}),
                    Contains("aerosol.machine") && Contains("needs this file"));
}

TEST_CASE("Cells of an aerosol lab's grid are at most half of a line wide") {
  CHECK_NOTHROW(meander({"aerosol.line_width_mm=0.04"}));
  CHECK_THROWS_WITH(meander({"aerosol.line_width_mm=0.039"}),
                    Contains("grid.pitch_x_mm") && Contains("aerosol.line_width_mm = 0.039"));
}

TEST_CASE("The aerosol lab refuses schemes and keys of other labs by name") {
  CHECK_THROWS_WITH(meander({"control.scheme='mpc'"}), Contains("control.scheme") && Contains("open_loop"));
  CHECK_THROWS_WITH(meander({"jet.dwell_us=20"}), Contains("jet.dwell_us"));
  CHECK_THROWS_WITH(meander({"control.smf.output_limit=1.0"}), Contains("control.smf.output_limit"));
}

TEST_CASE("Ways of an aerosol print keep to the stage's own limits, in the part's frame") {
  const Experiment e = meander({"stage.x_min_mm=-7", "stage.x_max_mm=9"});
  Machine machine = load_machine(FIRN_SOURCE_DIR "/labs/aerosol.toml");
  machine.aerosol.stage_origin_x_mm = 30.0;
  machine.aerosol.substrate_moves = 1;
  const control::LineSetup s = line_setup(e, machine, {});
  CHECK(s.machine.stage_low.x_mm == -7.0);
  CHECK(s.machine.stage_high.x_mm == 9.0);
  CHECK(s.machine.stage_origin.x_mm == 0.0);
  CHECK_FALSE(s.machine.substrate_moves);
  CHECK(s.machine.axis.alpha_mm_s2 == machine.aerosol.acceleration_mm_s2);
}

TEST_CASE("Ways of an aerosol print keep to the travel of the machine, whichever of stage and nozzle moves") {
  const Experiment e = meander({"stage.x_min_mm=-40", "stage.x_max_mm=40"});
  Machine machine = load_machine(FIRN_SOURCE_DIR "/labs/aerosol.toml");
  machine.axis[0].low = 2.0;
  machine.axis[0].high = 50.0;
  machine.aerosol.stage_origin_x_mm = 30.0;
  machine.aerosol.substrate_moves = 1;
  const motion::AerosolMachine carries = line_setup_within_travel(e, machine, {}).machine;
  CHECK(carries.stage_low.x_mm == -20.0);
  CHECK(carries.stage_high.x_mm == 28.0);
  machine.aerosol.substrate_moves = 0;
  const motion::AerosolMachine carried = line_setup_within_travel(e, machine, {}).machine;
  CHECK(carried.stage_low.x_mm == -28.0);
  CHECK(carried.stage_high.x_mm == 20.0);
  CHECK(line_setup(e, machine, {}).machine.stage_low.x_mm == -40.0);  // as recorded runs went
}

TEST_CASE(
    "Open loop is the aerosol lab without feedback, and its instruments are stage, profiler, gas and "
    "platen") {
  CHECK(line_setup(meander(), {}, {}).feedback);
  const Experiment e = meander({"control.scheme='open_loop'"});
  CHECK_FALSE(line_setup(e, {}, {}).feedback);
  for (const char* node : {"stage", "laser_profiler", "gas", "heater", "scheduler", "safety"})
    CHECK(takes_part(e, node));
  for (const char* node : {"jet", "robot", "lamp", "camera"}) CHECK_FALSE(takes_part(e, node));
  const Experiment bare = meander({"gas.use='off'", "heater.platen_degC=-50"});
  for (const char* node : {"gas", "heater"}) CHECK_FALSE(takes_part(bare, node));
  CHECK(takes_part(Experiment{}, "gas") == false);
}

TEST_CASE("Width by the sheath's gas needs gas, and a sheath below its limit") {
  CHECK_NOTHROW(meander({"aerosol.width_by='gas'"}));
  CHECK_THROWS_WITH(meander({"aerosol.width_by='gas'", "gas.use='off'"}), Contains("needs gas.use"));
  CHECK_THROWS_WITH(meander({"aerosol.width_by='gas'", "gas.sheath_max_sccm=50"}),
                    Contains("gas.sheath_max_sccm = 50.0 sccm"));
  CHECK_THROWS_WITH(meander({"aerosol.width_by='speed'"}), Contains("camera.use"));
}

TEST_CASE("An aerosol lab without a profiler steers by width or not at all, and needs its camera") {
  const std::string none = "devices.laser_profiler.port='none'";
  const Experiment e = meander({none, "camera.use='on'", "aerosol.width_by='speed'"});
  CHECK_FALSE(takes_part(e, "laser_profiler"));
  CHECK(takes_part(e, "camera"));
  CHECK_NOTHROW(meander({none, "camera.use='on'", "aerosol.width_by='gas'"}));
  CHECK_NOTHROW(meander({none, "camera.use='on'", "control.scheme='open_loop'"}));
  CHECK_THROWS_WITH(meander({none, "control.scheme='open_loop'"}),
                    Contains("devices.laser_profiler.port") && Contains("camera.use"));
  CHECK_THROWS_WITH(meander({none, "camera.use='on'"}), Contains("section needs a profiler"));
  CHECK_THROWS_WITH(meander({none, "camera.use='on'", "aerosol.width_by='gas'", "aerosol.hold='height'"}),
                    Contains("aerosol.hold") && Contains("height needs a profiler"));
  CHECK_THROWS_WITH(meander({"devices.stage.port='none'"}), Contains("devices.stage.port"));
  CHECK_THROWS_WITH(load_experiment(FIRN_SOURCE_DIR "/experiments/cuboid.toml", {none}),
                    Contains("devices.laser_profiler.port"));
}

TEST_CASE("Limits of an aerosol lab's stage that leave it no travel are refused by file, keys and values") {
  const std::pair<std::vector<std::string>, const char*> wrong[] = {
      {{"stage.x_min_mm=60", "stage.x_max_mm=50"},
       "--set: stage.x_min_mm = 60.0 mm: must be below stage.x_max_mm = 50.0 mm"},
      {{"stage.y_min_mm=300"}, "--set: stage.y_min_mm = 300.0 mm: must be below stage.y_max_mm = 150.0 mm"},
      {{"stage.z_max_mm=-10"}, "stage.z_min_mm = -10.0 mm: must be below stage.z_max_mm = -10.0 mm"},
      {{"process.nozzle_gap_mm=90"}, "the nozzle's gap needs 90.000 mm to 90.000 mm, outside stage.z_min_mm"},
      {{"process.scan_speed_mm_s=60"},
       "process.scan_speed_mm_s = 60.0 mm/s: must not exceed stage.max_speed_mm_s = 50.0 mm/s"},
      {{"process.scan_speed_mm_s=5"}, "process.scan_speed_mm_s = 5.0 mm/s: needs 0.025 mm of run-up"},
      {{"process.pass_speed_mm_s=60", "camera.use='on'"},
       "process.pass_speed_mm_s = 60.0 mm/s: must not exceed stage.max_speed_mm_s = 50.0 mm/s"}};
  for (const auto& [set, why] : wrong) CHECK_THROWS_WITH(meander(set), Contains(why));
  auto files = read_with_includes(kMeander);
  files.emplace_back("my-lab.toml", "[stage]\nx_min_mm = 60.0\nx_max_mm = 50.0\n");
  CHECK_THROWS_WITH(
      parse_experiment(files, {}),
      Contains("my-lab.toml:2: stage.x_min_mm = 60.0 mm: must be below stage.x_max_mm = 50.0 mm"));
}

TEST_CASE("Gas and platen of an aerosol lab are refused by key, value and limit") {
  const std::pair<const char*, const char*> wrong[] = {
      {"gas.atomizer_sccm=101", "gas.atomizer_max_sccm = 100.0 sccm"},
      {"gas.sheath_sccm=501", "gas.sheath_max_sccm = 500.0 sccm"},
      {"gas.sheath_sccm=0", "ink without a sheath clogs"},
      {"gas.atomizer_sccm=0", "it carries the ink"},
      {"gas.atomizer_unit='AB'", "must be one letter"},
      {"gas.sheath_unit='A'", "two letters"},
      {"heater.platen_degC=70", "heater.high_degC = 60.0 degC"},
      {"heater.low_degC=41", "heater.low_degC = 41.0 degC"},
      {"heater.tip_degC=20", "heater.tip_degC"}};
  for (const auto& [set, why] : wrong) CHECK_THROWS_WITH(meander({set}), Contains(why));
  CHECK_NOTHROW(meander({"gas.use='off'", "gas.sheath_sccm=0"}));
  const std::string ice = FIRN_SOURCE_DIR "/labs/ice-cobra600.toml";
  CHECK_THROWS_WITH(load_experiment(ice, {"heater.platen_degC=40"}), Contains("heater.platen_degC"));
}
