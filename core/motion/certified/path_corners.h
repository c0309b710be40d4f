// find_corners() decides which points of a path are corners, and which are samples of a curve that turns.
#pragma once

#include <cstddef>
#include <vector>

#include "core/motion/kinematics/path_input.h"
#include "core/motion/trajectory/plan.h"

namespace firn::motion {

/// Corners: where the path turns back, or turns by more than the split angle over a length that rounding does
/// not reach, and not as samples of an arc do where points are held.
/// @param kept on return the vertices of the thinned path between which the angles are
/// @param corners on return ascending indices of points, among them both ends
void find_corners(const CleanPath& path, const PlanOptions& options, std::vector<std::size_t>& kept,
                  std::vector<std::size_t>& corners);

}  // namespace firn::motion
