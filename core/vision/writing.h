// find_writing() finds the characters that programs of cameras write into pictures.
#pragma once

#include <vector>

#include "core/vision/scene.h"

namespace firn::vision {

/// A line of writing is at least three components side by side on one baseline, as high as capitals or small
/// letters, or two whole words, of which at least half consist of strokes or are slim, closed digits:
/// droplets of a train are as wide as their box, with or without a tail. The neighbours that belong to it are
/// written too. A scale bar is writing, too. A bar over the picture's whole width holds writing alone.
/// @param order the components that are looked at
/// @returns by component
std::vector<bool> find_writing(const std::vector<Component>& components,
                               const std::vector<std::size_t>& order, const Frame& frame);

}  // namespace firn::vision
