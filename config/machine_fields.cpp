#include "config/field_rows.h"
#include "config/machine.h"

namespace firn {
using namespace field_rows;

namespace {

constexpr double kMm = 1e5, kDegrees = 3600.0, kRate = 1e6, kJerk = 1e9;

Table general(Machine& m) {
  return {
      {"machine.name", &m.name, "", {}, "stands in the trajectory file"},
      {"machine.kind",
       &m.kind,
       "",
       {.choices = {"scara", "stage", "aerosol"}},
       "which of the sections below count"},
      {"machine.tick_s", &m.tick_s, "s", above(0, 1), "period of the emitted samples [Barnett 2012, 4.1.6]"},
      {"total.speed_mm_s", &m.speed_mm_s, "mm/s", above(0, kRate),
       "scara, stage: total Cartesian speed (4.10)"},
      {"total.acceleration_mm_s2", &m.acceleration_mm_s2, "mm/s^2", above(0, kRate),
       "the same of acceleration"},
      {"total.jerk_mm_s3", &m.jerk_mm_s3, "mm/s^3", above(0, kJerk), "the same of jerk"},
      {"orientation.rate_deg_s", &m.orientation_rate_deg_s, "deg/s", within(0, kRate),
       "scara: largest turning of the tool; 0 = not limited"},
      {"orientation.acceleration_deg_s2", &m.orientation_acceleration_deg_s2, "deg/s^2", within(0, kRate),
       "the same of acceleration"},
      {"orientation.jerk_deg_s3", &m.orientation_jerk_deg_s3, "deg/s^3", within(0, kJerk),
       "the same of jerk"},
      {"scara.link_1_mm", &m.link_1_mm, "mm", above(0, kMm), "joint 1 to joint 2 (Table 2-1)"},
      {"scara.link_2_mm", &m.link_2_mm, "mm", above(0, kMm), "joint 2 to the flange"},
      {"scara.elbow", &m.elbow, "", within(-1, 1), "preferred: 1 = theta_2 > 0, -1 = theta_2 < 0"},
  };
}

Table rotary(AxisConfig& a, const std::array<std::string_view, 5>& keys) {
  return {
      {keys[0], &a.low, "deg", within(-kDegrees, kDegrees), "scara: end of the range"},
      {keys[1], &a.high, "deg", within(-kDegrees, kDegrees), "other end"},
      {keys[2], &a.rate, "deg/s", within(0, kRate), "largest rate; 0 = not limited"},
      {keys[3], &a.acceleration, "deg/s^2", within(0, kRate), "largest acceleration; 0 = not limited"},
      {keys[4], &a.jerk, "deg/s^3", within(0, kJerk), "largest jerk; 0 = not limited"},
  };
}

Table linear(AxisConfig& a, const std::array<std::string_view, 5>& keys, std::string_view whose) {
  return {
      {keys[0], &a.low, "mm", within(-kMm, kMm), whose},
      {keys[1], &a.high, "mm", within(-kMm, kMm), "other end"},
      {keys[2], &a.rate, "mm/s", within(0, kRate), "largest rate; 0 = not limited"},
      {keys[3], &a.acceleration, "mm/s^2", within(0, kRate), "largest acceleration; 0 = not limited"},
      {keys[4], &a.jerk, "mm/s^3", within(0, kJerk), "largest jerk; 0 = not limited"},
  };
}

Table tool(ToolConfig& t, const std::array<std::string_view, 3>& keys) {
  return {
      {keys[0], &t.x_mm, "mm", within(-kMm, kMm),
       "scara: the tool in the flange's frame (minus Table 3-1's origin)"},
      {keys[1], &t.y_mm, "mm", within(-kMm, kMm), "the same along y"},
      {keys[2], &t.z_mm, "mm", within(-kMm, kMm), "the same along z"},
  };
}

Table valve(ValveConfig& v) {
  return {
      {"valve.pulse_s", &v.pulse_s, "s", above(0, 1), "width of each pulse; the calibration belongs to it"},
      {"valve.hz_per_mm3_s", &v.hz_per_mm3_s, "Hz/(mm^3/s)", above(0, 1e6),
       "c_ff of (5.14), while there is no table"},
      {"valve.table_hz", &v.table_hz, "Hz", above(0, 1e5), "the calibration's frequencies, ascending [6.1]"},
      {"valve.table_mm3_s", &v.table_mm3_s, "mm^3/s", above(0, 1e6), "the flow at each of them, ascending"},
      {"valve.tick_s", &v.tick_s, "s", above(0, 1), "resolution of the controller's list [2.3.1]"},
      {"valve.max_duration_s", &v.max_duration_s, "s", above(0, 1e5), "longest list; at most 65,536 ticks"},
      {"valve.max_entries", &v.max_entries, "", within(1, 1e6), "pulses in one list"},
      {"valve.min_pulse_s", &v.min_pulse_s, "s", above(0, 1), "narrowest pulse the valve follows"},
      {"valve.max_frequency_hz", &v.max_frequency_hz, "Hz", above(0, 1e5), "the valve's own maximum"},
      {"valve.max_flow_mm3_s", &v.max_flow_mm3_s, "mm^3/s", above(0, 1e6), "Table 2-2"},
  };
}

Table aerosol(AerosolConfig& a) {
  return {
      {"aerosol.v_max_mm_s", &a.v_max_mm_s, "mm/s", above(0, kRate),
       "largest speed of each axis [Thompson 2014]"},
      {"aerosol.acceleration_mm_s2", &a.acceleration_mm_s2, "mm/s^2", above(0, kRate),
       "alpha: of the blends, per axis"},
      {"aerosol.shutter_delay_s", &a.shutter_delay_s, "s", within(0, 60), "command to open or closed"},
      {"aerosol.flow_mm3_s", &a.flow_mm3_s, "mm^3/s", above(0, 1e6), "of ink, which never stops"},
      {"aerosol.tick_s", &a.tick_s, "s", above(0, 1), "period of the emitted samples"},
      {"aerosol.substrate_moves", &a.substrate_moves, "", within(0, 1),
       "1 = the stage carries the substrate (II-B)"},
      {"aerosol.stage_origin_x_mm", &a.stage_origin_x_mm, "mm", within(-kMm, kMm),
       "stage position of the pattern's origin"},
      {"aerosol.stage_origin_y_mm", &a.stage_origin_y_mm, "mm", within(-kMm, kMm), "the same along y"},
  };
}

}  // namespace

std::vector<Field> machine_fields(Machine& m) {
  Table t = general(m);
  add(t, rotary(m.joint[0], {"joint_1.low_deg", "joint_1.high_deg", "joint_1.rate_deg_s",
                             "joint_1.acceleration_deg_s2", "joint_1.jerk_deg_s3"}));
  add(t, rotary(m.joint[1], {"joint_2.low_deg", "joint_2.high_deg", "joint_2.rate_deg_s",
                             "joint_2.acceleration_deg_s2", "joint_2.jerk_deg_s3"}));
  add(t, linear(m.joint[2],
                {"joint_3.low_mm", "joint_3.high_mm", "joint_3.rate_mm_s", "joint_3.acceleration_mm_s2",
                 "joint_3.jerk_mm_s3"},
                "scara: end of the vertical stroke"));
  add(t, rotary(m.joint[3], {"joint_4.low_deg", "joint_4.high_deg", "joint_4.rate_deg_s",
                             "joint_4.acceleration_deg_s2", "joint_4.jerk_deg_s3"}));
  t.push_back({"stage.axes", &m.axes, "", within(2, 3), "stage: x, y or x, y, z"});
  add(t, linear(m.axis[0],
                {"axis_1.low_mm", "axis_1.high_mm", "axis_1.rate_mm_s", "axis_1.acceleration_mm_s2",
                 "axis_1.jerk_mm_s3"},
                "stage, aerosol: end of the travel"));
  add(t, linear(m.axis[1],
                {"axis_2.low_mm", "axis_2.high_mm", "axis_2.rate_mm_s", "axis_2.acceleration_mm_s2",
                 "axis_2.jerk_mm_s3"},
                "stage, aerosol: end of the travel"));
  add(t, linear(m.axis[2],
                {"axis_3.low_mm", "axis_3.high_mm", "axis_3.rate_mm_s", "axis_3.acceleration_mm_s2",
                 "axis_3.jerk_mm_s3"},
                "stage: end of the travel"));
  add(t, tool(m.water, {"tool_water.x_mm", "tool_water.y_mm", "tool_water.z_mm"}));
  add(t, tool(m.scaffold, {"tool_scaffold.x_mm", "tool_scaffold.y_mm", "tool_scaffold.z_mm"}));
  add(t, tool(m.laser, {"tool_laser.x_mm", "tool_laser.y_mm", "tool_laser.z_mm"}));
  add(t, valve(m.valve));
  add(t, aerosol(m.aerosol));
  return t;
}

}  // namespace firn
