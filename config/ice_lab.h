// Converts the configuration of the ice lab and of its machine to the option structs of core.
#pragma once

#include "config/experiment.h"
#include "config/machine.h"
#include "core/control/surface/surface_controller.h"
#include "core/planning/path_planning.h"

namespace firn {

/// The machine's tool_laser moved by what calibration found (laser_point.offset_*): its point is the middle
/// of the range. Heights are higher by laser_point.offset_z_mm, so the tool stands higher by as much.
motion::Tool laser_tool(const Machine& machine, const Experiment& experiment);

/// One valve as the lab believes it to be. @throws std::invalid_argument: a flow curve that is none
deposition::ValveSetting valve_setting(const ValveLineConfig& valve);

/// The machine's, with lists of at most ice.max_pulses, and 0.2 s shorter than a slot of the robot (8192
/// points).
deposition::ValveLimits list_limits(const Machine& machine, const Experiment& experiment);

/// @throws std::invalid_argument: a machine that is no arm
planning::PlanningArm planning_arm(const Machine& machine);

/// @throws std::invalid_argument: a machine that is no arm, a flow curve that is none
planning::PlanningSetup planning_setup(const Experiment& experiment, const Machine& machine);

/// @param last_layer of the print
control::SurfaceOptions surface_options(const Experiment& experiment, int last_layer);

}  // namespace firn
