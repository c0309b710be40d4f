// remove_drawn_lines() takes out the straight lines that programs of cameras draw: frames, crosshairs.
#pragma once

#include <vector>

#include "core/vision/scene.h"

namespace firn::vision {

/// A drawn line is parallel to the picture's sides and a few pixels thick. It crosses the whole picture, or
/// it is at least half as long and has a parallel with the same ends: a ligament has neither. An outline of a
/// box is drawn, too. Objects that a line crosses keep their pixels on both of its sides.
/// A line that is not darker than the ground cuts an object in two: they are joined again where one of them
/// reaches the picture's edge.
/// @returns the components of the rest
std::vector<Component> remove_drawn_lines(std::vector<Component>&& components, const Frame& frame);

}  // namespace firn::vision
