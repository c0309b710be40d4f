#include "config/machine.h"

#include <catch2/catch.hpp>
#include <fstream>
#include <numbers>
#include <sstream>

#include "config/error.h"

using namespace firn;
using Catch::Contains;

namespace {

std::string machine_mistake(const std::string& toml) {
  try {
    parse_machine(toml, "m.toml");
  } catch (const ConfigError& e) {
    return e.what();
  }
  return "";
}

}  // namespace

TEST_CASE("labs/cobra600.toml says what the defaults say, and both are the thesis's arm and limits") {
  Machine file = load_machine(FIRN_SOURCE_DIR "/labs/cobra600.toml"), defaults;
  const std::vector<Field> a = machine_fields(file), b = machine_fields(defaults);
  for (std::size_t n = 0; n < a.size(); ++n) CHECK(value_text(a[n]) == value_text(b[n]));
  const motion::MotionLimits limits = motion_limits(file), thesis = motion::cobra600_limits();
  CHECK(limits.position.jerk == thesis.position.jerk);
  for (std::size_t j = 0; j < 4; ++j) {
    CHECK(limits.joint[j].rate == Approx(thesis.joint[j].rate));
    CHECK(limits.joint[j].acceleration == Approx(thesis.joint[j].acceleration));
    CHECK(limits.joint[j].jerk == Approx(thesis.joint[j].jerk));
  }
  const auto arm = make_arm(file), cobra = motion::make_scara(motion::cobra600());
  REQUIRE(arm->joints() == cobra->joints());
  for (int j = 0; j < arm->joints(); ++j) {
    CHECK(arm->range(j).low == Approx(cobra->range(j).low));
    CHECK(arm->range(j).high == Approx(cobra->range(j).high));
  }
  const std::vector<motion::Tool> ours = tools(file), theirs = motion::cobra600_tools();
  REQUIRE(ours.size() == theirs.size());
  for (std::size_t n = 0; n < ours.size(); ++n) {
    CHECK(ours[n].name == theirs[n].name);
    CHECK(ours[n].x_mm == theirs[n].x_mm);
    CHECK(ours[n].y_mm == theirs[n].y_mm);
  }
}

TEST_CASE("A mistake in a machine file names file, line, key, value and limit, or the nearest key") {
  CHECK_THAT(machine_mistake("[machine]\nkindd = \"scara\"\n"),
             Contains("m.toml:2") && Contains("machine.kind"));
  CHECK_THAT(machine_mistake("[machine]\nkind = \"scarab\"\n"),
             Contains("m.toml:2") && Contains("did you mean \"scara\"?"));
  CHECK_THAT(machine_mistake("[total]\njerk_mm_s3 = 0\n"),
             Contains("m.toml:2") && Contains("(0, 1e+09] mm/s^3"));
  CHECK_THAT(machine_mistake("[total]\nspeed_mm_s = nan\n"), Contains("total.speed_mm_s"));
  CHECK_THAT(machine_mistake("[joint_1]\nlow_deg = 120.0\n"),
             Contains("joint_1.high_deg") && Contains("above the other end"));
  CHECK_THAT(machine_mistake("[machine]\nkind = \"stage\"\n[scara]\nlink_1_mm = 3.0\n"),
             Contains("m.toml:4") && Contains("kind \"stage\""));
  CHECK_THAT(machine_mistake("[aerosol]\nv_max_mm_s = 3.0\n"),
             Contains("aerosol.v_max_mm_s") && Contains("kind \"scara\""));
  CHECK_THAT(machine_mistake("[scara]\nelbow = 0\n"), Contains("1 or -1"));
  CHECK_THAT(machine_mistake("[valve]\ntable_hz = [1.0, 2.0]\n"), Contains("as many entries"));
  CHECK_THAT(machine_mistake("[valve]\ntable_hz = [1.0, 2.0]\ntable_mm3_s = [2.0, 1.0]\n"),
             Contains("must ascend"));
  CHECK_THAT(machine_mistake("[valve]\ntable_hz = [1.0, \"x\"]\n"), Contains("list of numbers"));
  CHECK_THAT(machine_mistake("[valve]\ntable_hz = [1.0, -1.0]\n"), Contains("every entry must lie in (0,"));
  CHECK_THAT(machine_mistake("[valve]\npulse_s = 0.0001\n"), Contains("min_pulse_s"));
  CHECK_THAT(machine_mistake("[valve]\nmax_duration_s = 200.0\n"), Contains("65,536"));
  CHECK_THAT(machine_mistake("include = \"x.toml\"\n"), Contains("include"));
  CHECK_THAT(machine_mistake("[machine\n"), Contains("m.toml:1"));
  CHECK_THROWS_AS(load_machine("no/such.toml"), ConfigError);
}

TEST_CASE("Limits of the tool's orientation are read in degrees, 0 is none, and a stage has none") {
  const Machine m = parse_machine("[orientation]\nrate_deg_s = 90\njerk_deg_s3 = 1800\n", "m.toml");
  const motion::RateLimits o = motion_limits(m).orientation;
  CHECK(o.rate == Approx(0.5 * std::numbers::pi));
  CHECK(o.acceleration == motion::kUnlimited);
  CHECK(o.jerk == Approx(10.0 * std::numbers::pi));
  CHECK_THROWS_WITH(parse_machine("[machine]\nkind = \"stage\"\n[orientation]\nrate_deg_s = 90\n", "m.toml"),
                    Catch::Contains("does not belong to a machine of kind"));
}

TEST_CASE("A stage becomes a Cartesian arm without rotary limits, and a valve table a flow curve") {
  const Machine m = parse_machine(
      "[machine]\nkind = \"stage\"\n[stage]\naxes = 3\n[axis_1]\nlow_mm = -10\nhigh_mm = 20\nrate_mm_s = 5\n"
      "[valve]\ntable_hz = [100, 200]\ntable_mm3_s = [20, 50]\n",
      "m.toml");
  const auto arm = make_arm(m);
  CHECK(arm->joints() == 3);
  CHECK(arm->range(0).low == -10.0);
  CHECK(motion_limits(m).joint[0].rate == 5.0);
  CHECK(motion_limits(m).joint[1].rate == motion::kUnlimited);
  CHECK(tools(m).size() == 1);
  CHECK(valve_setting(m.valve).curve.frequency_hz(50.0) == Approx(200.0));
  CHECK_NOTHROW(deposition::check(valve_limits(m.valve)));
}

TEST_CASE("Joint limits are degrees in the file and radians in the planner, the stroke millimetres in both") {
  const Machine m = parse_machine(
      "[joint_1]\nlow_deg = -90\nhigh_deg = 45\nrate_deg_s = 180\n[joint_3]\nlow_mm = 5\nhigh_mm = 150\n"
      "rate_mm_s = 40\n",
      "m.toml");
  const auto arm = make_arm(m);
  CHECK(arm->range(0).low == Approx(-0.5 * std::numbers::pi));
  CHECK(arm->range(0).high == Approx(0.25 * std::numbers::pi));
  CHECK(arm->range(2).low == 5.0);
  CHECK(arm->range(2).high == 150.0);
  CHECK(motion_limits(m).joint[0].rate == Approx(std::numbers::pi));
  CHECK(motion_limits(m).joint[2].rate == 40.0);
}

TEST_CASE("Each kind of machine has its own sections and no other's") {
  const std::pair<const char*, const char*> foreign[] = {
      {"scara", "[axis_1]\nlow_mm = 1\n"},       {"scara", "[stage]\naxes = 2\n"},
      {"stage", "[joint_1]\nlow_deg = 1\n"},     {"stage", "[tool_water]\nx_mm = 1\n"},
      {"stage", "[aerosol]\nv_max_mm_s = 2\n"},  {"aerosol", "[valve]\npulse_s = 0.002\n"},
      {"aerosol", "[total]\nspeed_mm_s = 20\n"}, {"aerosol", "[axis_3]\nlow_mm = 1\n"},
      {"aerosol", "[scara]\nlink_1_mm = 200\n"}};
  for (const auto& [kind, section] : foreign)
    CHECK_THAT(machine_mistake("[machine]\nkind = \"" + std::string(kind) + "\"\n" + section),
               Contains("does not belong to a machine of kind \"" + std::string(kind) + "\""));
  const std::pair<const char*, const char*> own[] = {{"scara", "[valve]\npulse_s = 0.002\n"},
                                                     {"stage", "[axis_3]\nlow_mm = 1\n"},
                                                     {"stage", "[total]\nspeed_mm_s = 20\n"},
                                                     {"aerosol", "[axis_1]\nlow_mm = 1\n"},
                                                     {"aerosol", "[aerosol]\nv_max_mm_s = 2\n"}};
  for (const auto& [kind, section] : own)
    CHECK(machine_mistake("[machine]\nkind = \"" + std::string(kind) + "\"\n" + section) == "");
}

TEST_CASE("An empty range of a stage's axis is refused") {
  CHECK_THAT(machine_mistake("[machine]\nkind = \"stage\"\n[axis_2]\nlow_mm = 300\n"),
             Contains("axis_2.high_mm") && Contains("above the other end"));
}

TEST_CASE("docs/machines.md is what `firn config docs --machines` writes") {
  std::ifstream in(FIRN_SOURCE_DIR "/docs/machines.md");
  std::ostringstream committed;
  committed << in.rdbuf();
  const bool same = committed.str() == machine_markdown();
  CHECK(same);
}
