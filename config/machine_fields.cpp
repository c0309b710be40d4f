#include "config/field_rows.h"
#include "config/machine.h"

namespace firn {
using namespace field_rows;

namespace {

constexpr double kMm = 1e5, kDegrees = 3600.0, kRate = motion::kMaxRate;

Field with_unit(Field f, std::string_view unit) {
  f.unit = unit;
  return f;
}

Table general(Machine& m) {
  Table t{
      {"machine.name", &m.name, "", {}, "stands in the trajectory file"},
      {"machine.kind", &m.kind, "", one_of({"scara", "stage", "aerosol"}),
       "which of the sections below count"},
      {"machine.tick_s", &m.tick_s, "s", above(0, 1), "period of the emitted samples [Barnett 2012, 4.1.6]"},
  };
  add(t, rows("total.", m.position, motion::kPositionLimits));
  add(t,
      {
          with_unit(row("orientation.rate_deg_s", m.orientation.rate, motion::kAxisRate,
                        "scara: largest turning of the tool; 0 = not limited"),
                    "deg/s"),
          with_unit(row("orientation.acceleration_deg_s2", m.orientation.acceleration,
                        motion::kAxisAcceleration, "the same of acceleration"),
                    "deg/s^2"),
          with_unit(row("orientation.jerk_deg_s3", m.orientation.jerk, motion::kAxisJerk, "the same of jerk"),
                    "deg/s^3"),
          {"scara.link_1_mm", &m.link_1_mm, "mm", above(0, kMm), "joint 1 to joint 2 (Table 2-1)"},
          {"scara.link_2_mm", &m.link_2_mm, "mm", above(0, kMm), "joint 2 to the flange"},
          {"scara.elbow", &m.elbow, "", within(-1, 1), "preferred: 1 = theta_2 > 0, -1 = theta_2 < 0"},
      });
  return t;
}

// The keys of a joint's or axis' rates. @param unit "deg" or "mm"
Table rates(AxisConfig& a, const std::string& section, std::string_view unit) {
  const bool deg = unit == "deg";
  return {
      with_unit(row(section + (deg ? "rate_deg_s" : "rate_mm_s"), a.rate, motion::kAxisRate),
                deg ? "deg/s" : "mm/s"),
      with_unit(row(section + (deg ? "acceleration_deg_s2" : "acceleration_mm_s2"), a.acceleration,
                    motion::kAxisAcceleration),
                deg ? "deg/s^2" : "mm/s^2"),
      with_unit(row(section + (deg ? "jerk_deg_s3" : "jerk_mm_s3"), a.jerk, motion::kAxisJerk),
                deg ? "deg/s^3" : "mm/s^3"),
  };
}

Table rotary(AxisConfig& a, const std::string& section) {
  Table t{
      {section + "low_deg", &a.low, "deg", within(-kDegrees, kDegrees), "scara: end of the range"},
      {section + "high_deg", &a.high, "deg", within(-kDegrees, kDegrees), "other end"},
  };
  add(t, rates(a, section, "deg"));
  return t;
}

Table linear(AxisConfig& a, const std::string& section, std::string_view whose) {
  Table t{
      {section + "low_mm", &a.low, "mm", within(-kMm, kMm), whose},
      {section + "high_mm", &a.high, "mm", within(-kMm, kMm), "other end"},
  };
  add(t, rates(a, section, "mm"));
  return t;
}

Table tool(ToolConfig& t, const std::string& section) {
  return {
      {section + "x_mm", &t.x_mm, "mm", within(-kMm, kMm),
       "scara: the tool in the flange's frame (minus Table 3-1's origin)"},
      {section + "y_mm", &t.y_mm, "mm", within(-kMm, kMm), "the same along y"},
      {section + "z_mm", &t.z_mm, "mm", within(-kMm, kMm), "the same along z"},
  };
}

Table valve(ValveConfig& v) {
  Table t{
      row("valve.pulse_s", v.pulse_s, deposition::kValvePulse),
      {"valve.hz_per_mm3_s", &v.hz_per_mm3_s, "Hz/(mm^3/s)", deposition::kFrequencyPerFlow,
       "c_ff of (5.14), while there is no table"},
      {"valve.table_hz", &v.table_hz, "Hz", above(0, 1e5), "the calibration's frequencies, ascending [6.1]"},
      {"valve.table_mm3_s", &v.table_mm3_s, "mm^3/s", above(0, 1e6), "the flow at each of them, ascending"},
  };
  add(t, rows("valve.", v, deposition::kValveLimits));
  return t;
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
  add(t, rotary(m.joint[0], "joint_1."));
  add(t, rotary(m.joint[1], "joint_2."));
  add(t, linear(m.joint[2], "joint_3.", "scara: end of the vertical stroke"));
  add(t, rotary(m.joint[3], "joint_4."));
  t.push_back({"stage.axes", &m.axes, "", within(2, 3), "stage: x, y or x, y, z"});
  add(t, linear(m.axis[0], "axis_1.", "stage, aerosol: end of the travel"));
  add(t, linear(m.axis[1], "axis_2.", "stage, aerosol: end of the travel"));
  add(t, linear(m.axis[2], "axis_3.", "stage: end of the travel"));
  add(t, tool(m.water, "tool_water."));
  add(t, tool(m.scaffold, "tool_scaffold."));
  add(t, tool(m.laser, "tool_laser."));
  add(t, valve(m.valve));
  add(t, aerosol(m.aerosol));
  return t;
}

}  // namespace firn
