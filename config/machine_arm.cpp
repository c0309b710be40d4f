#include <numbers>
#include <string>

#include "config/machine.h"

namespace firn {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

double unit_of_joint(std::size_t n) { return n == 2 ? 1.0 : kDegree; }  // J3 is the vertical stroke

}  // namespace

std::unique_ptr<motion::Arm> make_arm(const Machine& m) {
  if (m.kind == "scara") {
    motion::ScaraConfig spec{m.link_1_mm, m.link_2_mm, {}};
    for (std::size_t n = 0; n < 4; ++n)
      spec.ranges[n] = {m.joint[n].low * unit_of_joint(n), m.joint[n].high * unit_of_joint(n)};
    return motion::make_scara(spec);
  }
  motion::CartesianConfig spec;
  for (std::size_t n = 0; n < std::size_t(m.axes); ++n)
    spec.ranges.push_back({m.axis[n].low, m.axis[n].high});
  return motion::make_stage(spec);
}

motion::MotionLimits motion_limits(const Machine& m) {
  motion::MotionLimits limits;
  limits.position = m.position;
  check_options("total", motion::kPositionLimits, limits.position);
  if (m.kind == "scara") {
    limits.orientation = motion::rate_limits("orientation", m.orientation, kDegree);
    for (std::size_t n = 0; n < 4; ++n)
      limits.joint[n] = motion::rate_limits("joint_" + std::to_string(n + 1), m.joint[n], unit_of_joint(n));
  } else {
    for (std::size_t n = 0; n < std::size_t(m.axes); ++n)
      limits.joint[n] = motion::rate_limits("axis_" + std::to_string(n + 1), m.axis[n], 1.0);
  }
  return limits;
}

motion::ArmConfiguration preferred_configuration(const Machine& m) { return {m.elbow, 0}; }

std::vector<motion::Tool> tools(const Machine& m) {
  std::vector<motion::Tool> all{{"flange", 0.0, 0.0, 0.0}};
  if (m.kind != "scara") return all;
  all.push_back({"water", m.water.x_mm, m.water.y_mm, m.water.z_mm});
  all.push_back({"scaffold", m.scaffold.x_mm, m.scaffold.y_mm, m.scaffold.z_mm});
  all.push_back({"laser", m.laser.x_mm, m.laser.y_mm, m.laser.z_mm});
  return all;
}

deposition::ValveLimits valve_limits(const ValveConfig& v) { return v; }

deposition::ValveSetting valve_setting(const ValveConfig& v) {
  if (v.table_hz.empty())
    return {v.pulse_s, deposition::FlowCurve::proportional(v.hz_per_mm3_s, v.max_frequency_hz)};
  std::vector<deposition::FlowCurve::Row> rows;
  for (std::size_t n = 0; n < v.table_hz.size(); ++n) rows.push_back({v.table_hz[n], v.table_mm3_s[n]});
  return {v.pulse_s, deposition::FlowCurve(rows)};
}

}  // namespace firn
