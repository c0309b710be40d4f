// The ice hook wall, which keeps the scaffold from curling up [Barnett, 3.7, Fig. 3-8].
#pragma once

#include "core/slice/paths/path_options.h"
#include "core/geometry/region.h"

namespace firn::slice {

/// How many of the outermost scaffold paths of a layer are ice: one in layers 1 to two_from_layer, two up to
/// last_layer.
int hooks_in(std::int32_t layer, const HookOptions& options);

/// Takes the rings out that run round everything: those that bound scaffold from outside and lie in no hole
/// of the part.
Rings take_outermost(Rings& rings, const Region& part);

/// The scaffold, with as many further contours of its boundary width around it as let the outermost `hooks`
/// paths run round the whole part and keep their beads at least clearance_mm from it: ceil((d + width / 2 +
/// clearance) / boundary width) at most, with d the innermost hook's distance from the outer edge, which is
/// enough for any part.
Region room_for_hook(const Region& scaffold, const Region& part, int hooks, const PathOptions& options);

}  // namespace firn::slice
