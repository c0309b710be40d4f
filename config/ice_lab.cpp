#include "config/ice_lab.h"

#include <algorithm>
#include <stdexcept>

namespace firn {
namespace {

constexpr double kRobotSlot_points = 8192.0;
constexpr double kLatest_s = 0.2;  // maximum delay of pulses against the plan: ticks have 16 bits

}  // namespace

motion::Tool laser_tool(const Machine& machine, const Experiment& e) {
  const LaserPointConfig& l = e.laser_point;
  return {"laser", machine.laser.x_mm + l.offset_x_mm, machine.laser.y_mm + l.offset_y_mm,
          machine.laser.z_mm + l.offset_z_mm};
}

deposition::ValveSetting valve_setting(const ValveLineConfig& v) {
  ValveConfig c;
  c.pulse_s = v.pulse_us * 1e-6;
  c.hz_per_mm3_s = v.hz_per_mm3_s;
  c.table_hz = v.table_hz;
  c.table_mm3_s = v.table_mm3_s;
  return valve_setting(c);
}

deposition::ValveLimits list_limits(const Machine& machine, const Experiment& e) {
  deposition::ValveLimits l = valve_limits(machine.valve);
  l.max_entries = std::min(l.max_entries, std::int32_t(e.ice.max_pulses));
  l.max_duration_s = std::min(l.max_duration_s, (kRobotSlot_points - 1.0) * machine.tick_s - kLatest_s);
  return l;
}

planning::PlanningArm planning_arm(const Machine& machine) {
  if (machine.kind != "scara")
    throw std::invalid_argument("machine.kind = \"" + machine.kind +
                                "\": paths are planned for an arm, \"scara\"");
  return {make_arm(machine), motion_limits(machine), tools(machine), preferred_configuration(machine),
          machine.tick_s,    machine.position.rate};
}

planning::PlanningSetup planning_setup(const Experiment& e, const Machine& machine) {
  planning::PlanningSetup s;
  s.arm = planning_arm(machine);
  s.laser = laser_tool(machine, e);
  s.origin = {e.ice.origin_x_mm, e.ice.origin_y_mm};
  s.origin_z_mm = e.ice.origin_z_mm;
  s.nozzle_gap_mm = e.ice.nozzle_gap_mm;
  const auto speeds = [](const IceMaterialConfig& m) {
    return planning::MaterialSpeeds{m.boundary_mm_s, m.fill_mm_s, m.measure_mm_s};
  };
  s.speeds = {speeds(e.ice.water), speeds(e.ice.scaffold)};
  s.valves = {{valve_setting(e.valve_a), e.valve_a.latency_s},
              {valve_setting(e.valve_b), e.valve_b.latency_s}};
  s.valve_limits = list_limits(machine, e);
  if (e.ice.coverage == "off") s.coverage_window_mm = 0.0;
  s.version = surface_options(e, 0).version;
  return s;
}

control::SurfaceOptions surface_options(const Experiment& e, int last_layer) {
  control::SurfaceOptions o = e.control.surface;
  o.scheme = e.control.scheme;
  o.interval_mm = e.ice.interval_layers * e.ice.layer_height_mm;
  o.output_limit = e.control.smf.output_limit;
  o.feed_forward = e.flow.feed_forward != "off";
  o.last_layer = last_layer;
  o.stop_after = e.control.scheme == "open_loop" ? 0 : e.ice.max_saturated_intervals;
  o.stop_share = e.ice.saturated_share;
  o.target_offset_mm = e.control.target_offset_mm;
  o.smf = e.control.smf;
  o.extra = e.control.extra;
  return o;
}

}  // namespace firn
