// room_for_hook() and take_outermost() compute the ice hook wall, which prevents the scaffold from curling
// [Barnett, 3.7, Fig. 3-8].
#pragma once

#include "core/geometry/region.h"
#include "core/slice/paths/path_options.h"

namespace firn::slice {

/// Returns the number of outermost scaffold paths of a layer that are ice: one in layers 1 to two_from_layer,
/// two up to last_layer.
int hooks_in(std::int32_t layer, const HookOptions& options);

/// Removes and returns the outermost rings: those that bound scaffold from outside and lie in no hole of the
/// part.
geometry::Rings take_outermost(geometry::Rings& rings, const geometry::Region& part);

/// Returns the scaffold with as many additional contours of its boundary width as let the outermost `hooks`
/// paths enclose the whole part at least clearance_mm from it: at most ceil((d + width / 2 + clearance) /
/// boundary width), with d the distance of the innermost hook from the outer edge, which suffices for any
/// part.
geometry::Region room_for_hook(const geometry::Region& scaffold, const geometry::Region& part, int hooks,
                               const PathOptions& options);

}  // namespace firn::slice
