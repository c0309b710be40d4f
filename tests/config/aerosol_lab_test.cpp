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

TEST_CASE("Open loop is the aerosol lab without feedback, and stage and profiler are its only instruments") {
  CHECK(line_setup(meander(), {}, {}).feedback);
  const Experiment e = meander({"control.scheme='open_loop'"});
  CHECK_FALSE(line_setup(e, {}, {}).feedback);
  for (const char* node : {"stage", "laser_profiler", "scheduler", "safety"}) CHECK(takes_part(e, node));
  for (const char* node : {"jet", "robot", "lamp", "heater"}) CHECK_FALSE(takes_part(e, node));
}
