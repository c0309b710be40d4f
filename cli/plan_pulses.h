// Valve pulses of planned paths, and the rests that a path needs so that they fit the valve controller's lists.
#pragma once

#include <vector>

#include "config/machine.h"
#include "cli/path_file.h"
#include "core/deposition/pulses.h"
#include "core/motion/planner.h"

namespace firn {

/// The path's speed at each tick, from the emitted tool positions: what flow must match.
std::vector<double> speeds_at_ticks(const std::vector<Point2>& tool, double tick_s);

/// What a planned path asks of its valve: nominal flow (6.2) at the ticks, and the rests.
deposition::FlowDemand nominal_demand(const Path& path, const motion::PlanResult& result);

/// Nominal pulses of a planned path (6.2), (6.4)-(6.6), cut at its stops where the controller's limits need it.
/// @throws std::runtime_error: more flow than the valve gives, or no stop where one is needed
deposition::PulsePlan nominal_pulses(const InputPath& input, const motion::PlanResult& result, const ValveConfig& valve);

/// A rest that the path was given so that its pulses fit the lists.
struct AddedStop {
  double along_mm = 0.0;  ///< length of the path up to it
  Point2 at;
  bool corner = false;    ///< a point where the path turns by 5 degrees or more; else none lay near enough
};

/// Points at which the path of `demand` (with pulses.problem) should rest as well, in the input's order of points. The span
/// that is too long is divided into as few parts as fit with a tenth of room; each division moves to the slowest corner
/// near it, else to the nearest point, else a new point is put on the path (into input.path.points and its ceilings).
/// @returns the places; their indices are added to `stops` (ascending), whose entries are moved for new points.
std::vector<AddedStop> add_stops(InputPath& input, const deposition::FlowDemand& demand, const deposition::PulsePlan& pulses,
                                 std::vector<std::size_t>& stops);

}  // namespace firn
