// find_writing() finds the characters that programs of cameras write into pictures.
#pragma once

#include <vector>

#include "core/vision/scene.h"

namespace firn::vision {

/// A line of writing is at least three components side by side, of one height on one baseline, of which most
/// are not as wide as they are high: droplets of a train are round. What lies
/// between and beside them belongs to it.
/// A bar over the picture's whole width holds writing alone.
/// @param order the components that are looked at
/// @returns by component
std::vector<bool> find_writing(const std::vector<Component>& components,
                               const std::vector<std::size_t>& order, const Frame& frame);

}  // namespace firn::vision
