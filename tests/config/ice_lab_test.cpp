// The configuration of the ice lab in the option structs of core.
#include "config/ice_lab.h"

#include <catch2/catch.hpp>

using namespace firn;
using Catch::Contains;

namespace {

Experiment ice(const std::string& more = "") {
  return parse_experiment(
      "lab.kind = \"ice\"\ncontrol.scheme = \"smf\"\nice.paths = \"p\"\nice.machine = \"m\"\n"
      "control.smf.output_limit = 0.5\n" +
          more,
      "x.toml");
}

}  // namespace

TEST_CASE("The laser's tool is the machine's, moved by what its calibration found") {
  const Machine machine;
  const motion::Tool plain = laser_tool(machine, ice());
  const motion::Tool moved =
      laser_tool(machine, ice("laser_point.offset_x_mm = 0.25\nlaser_point.offset_y_mm = "
                              "-0.5\nlaser_point.offset_z_mm = 0.75\n"));
  CHECK(plain.x_mm == machine.laser.x_mm);
  CHECK(moved.x_mm == Approx(plain.x_mm + 0.25));
  CHECK(moved.y_mm == Approx(plain.y_mm - 0.5));
  CHECK(moved.z_mm == Approx(plain.z_mm + 0.75));
}

TEST_CASE(
    "Without a table a valve's curve is the one constant of (5.14), with one it runs through its rows") {
  const Experiment constant = ice("valve_a.hz_per_mm3_s = 5.0\nvalve_a.pulse_us = 1500.0\n");
  const deposition::ValveSetting one = valve_setting(constant.valve_a);
  CHECK(one.pulse_s == Approx(0.0015));
  CHECK(one.curve.frequency_hz(10.0) == Approx(50.0));
  CHECK(one.curve.frequency_hz(20.0) == Approx(100.0));
  const Experiment table = ice("[valve_b]\ntable_hz = [50, 200]\ntable_mm3_s = [10, 25]\n");
  const deposition::ValveSetting two = valve_setting(table.valve_b);
  CHECK(two.curve.frequency_hz(10.0) == Approx(50.0));
  CHECK(two.curve.frequency_hz(25.0) == Approx(200.0));
  CHECK(two.curve.flow_mm3_s(200.0) == Approx(25.0));
}

TEST_CASE("A list of pulses is bounded by the lab's number and by a slot of the robot, whichever is less") {
  Machine machine;
  const deposition::ValveLimits few = list_limits(machine, ice("ice.max_pulses = 100\n"));
  CHECK(few.max_entries == 100);
  machine.valve.max_entries = 50;
  CHECK(list_limits(machine, ice("ice.max_pulses = 100\n")).max_entries == 50);
  machine.valve.max_duration_s = 1e6;
  CHECK(list_limits(machine, ice()).max_duration_s == Approx(8191 * machine.tick_s - 0.2));
  machine.valve.max_duration_s = 3.0;
  CHECK(list_limits(machine, ice()).max_duration_s == 3.0);
}

TEST_CASE("Paths are planned for an arm alone") {
  Machine machine;
  CHECK_NOTHROW(planning_arm(machine));
  machine.kind = "stage";
  CHECK_THROWS_WITH(planning_arm(machine), Contains("machine.kind = \"stage\"") && Contains("scara"));
}

TEST_CASE("The planner gets origin, gap, speeds and latencies of both materials from the experiment") {
  const Experiment e =
      ice("ice.origin_x_mm = 250\nice.origin_y_mm = -90\nice.origin_z_mm = 15\nice.nozzle_gap_mm = 2.5\n"
          "valve_a.latency_s = 0.02\nvalve_b.latency_s = 0.03\n"
          "ice.water_boundary_mm_s = 21\nice.scaffold_fill_mm_s = 32\nice.scaffold_measure_mm_s = 33\n");
  const planning::PlanningSetup s = planning_setup(e, Machine{});
  CHECK(s.origin.x_mm == 250.0);
  CHECK(s.origin.y_mm == -90.0);
  CHECK(s.origin_z_mm == 15.0);
  CHECK(s.nozzle_gap_mm == 2.5);
  CHECK(s.speeds[0].boundary_mm_s == 21.0);
  CHECK(s.speeds[1].fill_mm_s == 32.0);
  CHECK(s.speeds[1].measure_mm_s == 33.0);
  REQUIRE(s.valves.size() == 2);
  CHECK(s.valves[0].latency_s == 0.02);
  CHECK(s.valves[1].latency_s == 0.03);
  CHECK(s.coverage_window_mm > 0.0);
  CHECK(planning_setup(ice("ice.coverage = \"off\"\n"), Machine{}).coverage_window_mm == 0.0);
}

TEST_CASE("The surface controller gets the interval's height, and an open loop never stops for saturation") {
  const Experiment e =
      ice("ice.interval_layers = 4\nice.layer_height_mm = 0.2\nice.max_saturated_intervals = 7\n");
  const control::SurfaceOptions o = surface_options(e, 12);
  CHECK(o.interval_mm == Approx(0.8));
  CHECK(o.stop_after == 7);
  CHECK(o.last_layer == 12);
  CHECK(o.output_limit == 0.5);
  CHECK_FALSE(o.feed_forward);
  CHECK(surface_options(ice("flow.feed_forward = \"on\"\n"), 0).feed_forward);
  const Experiment open = parse_experiment(
      "lab.kind = \"ice\"\ncontrol.scheme = \"open_loop\"\nice.paths = \"p\"\nice.machine = \"m\"\n"
      "control.smf.output_limit = 0.5\nice.max_saturated_intervals = 7\n",
      "x.toml");
  CHECK(surface_options(open, 12).stop_after == 0);
}
