// append_in_order() computes the printing order of the paths of a layer and the start points of closed ones.
#pragma once

#include <cstdint>
#include <span>

#include "core/slice/paths/layer_paths.h"
#include "core/slice/paths/path_options.h"

namespace firn::slice {

/// Appends `lines` (all of one kind) to `paths`, beginning near `at`: nearest neighbour, then at most
/// options.two_opt_passes passes of 2-opt over windows of at most 400 paths, which never lengthen the travel.
/// Closed lines begin at their seam, open ones may be reversed.
/// @param at position of the nozzle; afterwards its position at the end
/// @param widths of each line, in place of that of the info; may be empty
void append_in_order(const geometry::Rings& lines, const PathInfo& info, const PathOptions& options,
                     geometry::Point& at, LayerPaths& paths, std::span<const std::int32_t> widths = {});

}  // namespace firn::slice
