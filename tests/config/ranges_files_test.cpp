// Ranges of the keys of machine files and slicing settings.
#include <catch2/catch.hpp>

#include <algorithm>
#include <functional>

#include "config/machine.h"
#include "config/slice.h"
#include "core/motion/kinematics/limits.h"
#include "tests/config/ranges.h"

using namespace firn;
using firn::test::Kind;
using firn::test::tie;

namespace {

void slice_contours(SliceSettings& s) { slice::check(s.contour); }
void plan_paths(SliceSettings& s) { slice::check(path_options(s)); }

void check_valve(Machine& m) {
  m.valve.max_duration_s = std::min(m.valve.max_duration_s, 65536.0 * m.valve.tick_s);
  deposition::check(valve_limits(m.valve));
}

void check_pulse(Machine& m) {
  m.valve.min_pulse_s = std::min(m.valve.min_pulse_s, std::max(m.valve.pulse_s, 1e-12));
  deposition::check(valve_setting(m.valve), valve_limits(m.valve));
}

}  // namespace

TEST_CASE("Every numeric key of a machine has the range of what it configures") {
  using Build = std::function<void(Machine&)>;
  const auto arm = [](Machine& m) { motion::check_limits(motion_limits(m), 4); };
  const auto stage = [](Machine& m) {
    m.kind = "stage";
    m.axes = 3;
    motion::check_limits(motion_limits(m), 3);
  };
  Kind<Machine> kind{
      [](Machine& m) { return machine_fields(m); },
      {
          {"total.", arm},
          {"orientation.rate_deg_s", arm, "rate"},
          {"orientation.acceleration_deg_s2", arm, "acceleration"},
          {"orientation.jerk_deg_s3", arm, "jerk"},
          {"valve.tick_s", check_valve},
          {"valve.max_duration_s",
           [](Machine& m) {
             m.valve.tick_s = 1.0;
             deposition::check(valve_limits(m.valve));
           }},
          {"valve.max_entries", check_valve},
          {"valve.min_pulse_s", check_valve},
          {"valve.max_frequency_hz", check_valve},
          {"valve.max_flow_mm3_s", check_valve},
          {"valve.pulse_s", check_pulse},
          {"valve.hz_per_mm3_s", [](Machine& m) { valve_setting(m.valve); }},
      },
      {
          {"machine.tick_s", "pace of the samples that a planner writes"},
          {"scara.", "lengths of an arm"},
          {"stage.", "two axes or three"},
          {"tool_", "where a tool is"},
          {"valve.table_", "rows of a curve, which count together"},
          {"aerosol.", "of the aerosol planner, which takes any positive number"},
      },
  };
  for (const std::string axis :
       {"joint_1.", "joint_2.", "joint_3.", "joint_4.", "axis_1.", "axis_2.", "axis_3."}) {
    for (const std::string rate : {"rate", "acceleration", "jerk"})
      kind.probes.push_back({axis + rate, axis.starts_with("joint") ? Build(arm) : Build(stage), rate});
    kind.held_by_none.push_back({axis + "low_", "end of a range"});
    kind.held_by_none.push_back({axis + "high_", "end of a range"});
  }
  tie<Machine>(kind);
}

TEST_CASE("Every numeric key of slicing settings has the range of what it configures") {
  tie<SliceSettings>({
      [](SliceSettings& s) { return slice_fields(s); },
      {
          {"layer.height_mm", slice_contours, "layer_height_mm"},
          {"contour.tolerance_mm", slice_contours, "chord_tolerance_mm"},
          {"contour.min_spacing_mm", slice_contours},
          {"contour.closing_", slice_contours},
          {"part.first_offset_mm", plan_paths},
          {"part.boundar", plan_paths},
          {"part.fill_width_mm", plan_paths},
          {"part.gap_mm", plan_paths},
          {"scaffold.first_offset_mm", plan_paths},
          {"scaffold.boundar", plan_paths},
          {"scaffold.fill_width_mm", plan_paths},
          {"scaffold.gap_mm", plan_paths},
          {"support.buffer_mm", plan_paths},
          {"hook.two_from_layer", plan_paths},
          {"hook.last_layer", plan_paths},
          {"hook.clearance_mm", plan_paths},
          {"order.seed", plan_paths},
          {"order.two_opt_passes", plan_paths},
          {"order.start_", plan_paths},
          {"measure.spacing_mm", plan_paths},
          {"measure.inset_mm", plan_paths},
          {"measure.laser_", plan_paths},
      },
      {
          {"mesh.", "place of a mesh"},
          {"part.angle_deg", "any angle is a direction"},
          {"part.turn_deg", "any angle is a direction"},
          {"scaffold.angle_deg", "any angle is a direction"},
          {"scaffold.turn_deg", "any angle is a direction"},
          {"support.overhang_deg", "an angle, of which core takes radians"},
          {"hook.on", "a switch"},
          {"measure.on", "a switch"},
          {"measure.material", "a material's number"},
          {"measure.angle_deg", "any angle is a direction"},
          {"coverage.", "a report's own"},
          {"gcode.", "a file's own"},
      },
  });
}
