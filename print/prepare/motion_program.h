// Writes trajectories as programs of motion controllers: G-code with a feed per tick, and Aerotech's
// position-velocity-time (PVT) lines.
#pragma once

#include <string>
#include <vector>

#include "print/prepare/plan_job.h"

namespace firn {

/// Returns the first lines of a G-code program [RS-274/NGC]: mm, absolute, feed per minute, XY.
std::string gcode_head(const std::string& machine, const std::string& method);
/// Returns a G0 to the path's start, then one G1 per tick whose F is the chord over the tick; a tick at rest
/// is a dwell (G4 P, seconds). x, y in the frame of the paths; Z where the path has a height.
std::string gcode_lines(const PlannedItem& item);
std::string gcode_tail();

/// Returns AeroBasic lines: LINEAR to the start, then a PVT line per tick with each axis' position [mm],
/// velocity [mm/s] and the time since PVT INIT TIME ABS [s]. Positions are the machine's.
/// @param axes names of the axes, as X, Y. @pre PlanOptions::axis_rates
std::string pvt_lines(const PlannedItem& item, const std::vector<std::string>& axes);

}  // namespace firn
