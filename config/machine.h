// Machine holds a positioning machine as read from a file: arm or stage, limits, tools, valve
// (labs/cobra600.toml). Functions below convert a Machine to the planners' types. Keys: docs/machines.md,
// written from the table in machine_fields.cpp.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "config/fields.h"
#include "core/deposition/valve.h"
#include "core/motion/kinematics/arm.h"
#include "core/motion/kinematics/limits.h"
#include "core/motion/kinematics/tool.h"

namespace firn {

/// Range and limits of one joint or axis: degrees or mm as its keys say.
struct AxisConfig : motion::AxisRates {
  double low = 0.0, high = 0.0;
};

struct ToolConfig {
  double x_mm = 0.0, y_mm = 0.0, z_mm = 0.0;
};

/// Micro-solenoid valve and its controller [Barnett 2012, 2.3.1, 6.1].
struct ValveConfig : deposition::ValveLimits {
  double pulse_s = 0.00125;
  double hz_per_mm3_s = 4.0;     ///< c_ff of (5.14); used while the table is empty
  std::vector<double> table_hz;  ///< the calibration's rows, ascending
  std::vector<double> table_mm3_s;
};

/// Aerosol printer: a stage under a shuttered nozzle [Thompson 2014].
struct AerosolConfig {
  double v_max_mm_s = 3.0;
  double acceleration_mm_s2 = 30.0;
  double shutter_delay_s = 0.0;
  double flow_mm3_s = 0.001;
  double tick_s = 0.001;
  std::int32_t substrate_moves = 1;  ///< 1 = the stage carries the substrate: it moves by minus the path
  double stage_origin_x_mm = 0.0, stage_origin_y_mm = 0.0;
};

/// Defaults are the Cobra 600 of the ice printer [Barnett 2012, Tables 2-1, 2-2, 3-1, (4.10)].
struct Machine {
  std::string name = "cobra600";
  std::string kind = "scara";                               ///< scara | stage | aerosol
  double tick_s = 0.016;                                    ///< of the emitted trajectory
  motion::RateLimits position = motion::kCobra600Position;  ///< total Cartesian
  motion::AxisRates orientation;                            ///< yaw, degrees
  double link_1_mm = 325.0, link_2_mm = 275.0;
  std::int32_t elbow = 1;  ///< preferred: +1 = theta_2 > 0, -1 = theta_2 < 0
  std::array<AxisConfig, 4> joint{{{motion::kCobra600Joint1, -105, 105},
                                   {motion::kCobra600Joint2, -150, 150},
                                   {{}, 0, 210},
                                   {{}, -360, 360}}};
  std::int32_t axes = 2;  ///< of a stage: 2 or 3
  std::array<AxisConfig, 3> axis{{{{}, 0, 300}, {{}, 0, 300}, {{}, 0, 100}}};
  ToolConfig water{0.1, 0.3, 0.0}, scaffold{-0.2, -8.2, 0.0}, laser{30.0, -19.0, 0.0};
  ValveConfig valve;
  AerosolConfig aerosol;
};

/// Returns every field, in the order of the documentation.
std::vector<Field> machine_fields(Machine& machine);

/// @throws ConfigError naming file, line, key, value and limit: unknown keys (with the nearest known one),
/// keys of another kind of machine, ranges that are empty, a valve table whose columns differ or do not
/// ascend
Machine parse_machine(const std::string& toml_text, const std::string& file_name);
Machine load_machine(const std::filesystem::path& path);

/// Returns the documentation of all keys.
std::string machine_markdown();

// Conversions to the planners' types. @pre made by parse_machine(); make_arm and motion_limits not for an
// aerosol machine
std::unique_ptr<motion::Arm> make_arm(const Machine& machine);
motion::MotionLimits motion_limits(const Machine& machine);
motion::ArmConfiguration preferred_configuration(const Machine& machine);
/// "flange" and, on an arm, "water", "scaffold" and "laser".
std::vector<motion::Tool> tools(const Machine& machine);
deposition::ValveLimits valve_limits(const ValveConfig& valve);
deposition::ValveSetting valve_setting(const ValveConfig& valve);

}  // namespace firn
