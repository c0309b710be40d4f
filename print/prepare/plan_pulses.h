// Computes the valve pulses of planned paths, and the rests that a path needs so that its pulses fit the
// valve controller's lists.
#pragma once

#include <vector>

#include "config/machine.h"
#include "core/deposition/pulses.h"
#include "core/motion/insert_stops.h"
#include "core/motion/planner.h"
#include "files/path/path_file.h"

namespace firn {

/// Computes the flow demand of a planned path on its valve: nominal flow (6.2) at the ticks, and the rests.
deposition::FlowDemand nominal_demand(const Path& path, const motion::PlanResult& result);

/// Computes the nominal pulses of a planned path (6.2), (6.4)-(6.6), cut at its stops where the controller's
/// limits require it.
/// @throws std::runtime_error: the flow exceeds the valve's maximum, or a required stop is missing
deposition::PulsePlan nominal_pulses(const InputPath& input, const motion::PlanResult& result,
                                     const ValveConfig& valve);

using AddedStop = motion::InsertedStop;

/// Returns the points at which the path of `demand` (with pulses.problem) must rest as well, in the input's
/// order of points (core/motion/insert_stops.h).
std::vector<AddedStop> add_stops(InputPath& input, const deposition::FlowDemand& demand,
                                 const deposition::PulsePlan& pulses, std::vector<std::size_t>& stops);

}  // namespace firn
