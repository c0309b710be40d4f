// Converts the configuration of the ice lab and of its machine to the option structs of core.
#pragma once

#include "config/experiment.h"
#include "config/machine.h"
#include "core/control/surface/surface_controller.h"
#include "core/planning/path_planning.h"

namespace firn {

/// Returns the machine's tool_laser moved by the calibrated offset (laser_point.offset_*). The tool's point
/// is the middle of the measuring range. Heights increase by laser_point.offset_z_mm, so the tool is higher
/// by the same amount.
motion::Tool laser_tool(const Machine& machine, const Experiment& experiment);

/// Returns the lab's model of one valve. @throws std::invalid_argument: an invalid flow curve
deposition::ValveSetting valve_setting(const ValveLineConfig& valve);

/// Returns the machine's valve limits, with lists of at most ice.max_pulses, and 0.2 s shorter than a slot of
/// the robot (8192 points).
deposition::ValveLimits list_limits(const Machine& machine, const Experiment& experiment);

/// @throws std::invalid_argument: a machine that is no arm
planning::PlanningArm planning_arm(const Machine& machine);

/// @throws std::invalid_argument: a machine that is no arm, an invalid flow curve
planning::PlanningSetup planning_setup(const Experiment& experiment, const Machine& machine);

/// @param last_layer of the print
control::SurfaceOptions surface_options(const Experiment& experiment, int last_layer);

}  // namespace firn
