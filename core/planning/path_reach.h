// Reports the paths of a print that the arm cannot follow, before anything is planned or printed.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "core/planning/path_planning.h"

namespace firn::planning {

/// One path that is out of the arm's reach or of a joint's range, or whose tool the arm does not have.
struct Unreachable {
  PathTask task;
  std::string text;  ///< "layer 9, deposition path 11: " and the reason with point, value and limit
};

/// Checks every deposition and measurement path of a print, in printing order, without planning it.
/// @param most ends the search after so many
std::vector<Unreachable> unreachable_paths(const TaskPlanner& planner, const slice::PrintPaths& paths,
                                           const PlanningSetup& setup, std::size_t most);

/// The message about a print whose first unreachable path is `first`.
std::string refusal(const Unreachable& first);

}  // namespace firn::planning
