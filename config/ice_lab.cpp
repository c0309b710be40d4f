#include "config/ice_lab.h"

#include <algorithm>

namespace firn {
namespace {

constexpr double kRobotSlot_points = 8192.0;
constexpr double kLatest_s = 0.2;  // pulses may come so much later than planned: ticks have 16 bits

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

control::SurfaceOptions surface_options(const Experiment& e, int last_layer) {
  control::SurfaceOptions o = e.control.surface;
  o.scheme = e.control.scheme;
  o.interval_mm = e.ice.interval_layers * e.ice.layer_height_mm;
  o.output_limit = e.control.smf.output_limit;
  o.feed_forward = e.flow.feed_forward == "on";
  o.last_layer = last_layer;
  o.stop_after = e.control.scheme == "open_loop" ? 0 : e.ice.max_saturated_intervals;
  o.stop_share = e.ice.saturated_share;
  o.smf = e.control.smf;
  return o;
}

}  // namespace firn
