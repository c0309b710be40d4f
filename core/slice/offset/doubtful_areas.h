// Do the rings of a thinned outline bound the areas that those of its contours would?
#pragma once

#include <span>

#include "core/slice/offset/exact_tips.h"
#include "core/geometry/meeting.h"

namespace firn::slice {

/// Lists where they may not, as far as straits and small areas tell: walls within twice the thinning of 2 d
/// apart, or an area that hardly holds a disc of radius d, may be closed by one and open in the other.
/// @param rings at distance d; `checked` lists those of their edges that face each other within `facing`
/// @param peaks where the front of the thinned outline has ended, within the thinning of d
void doubt_areas(const Rings& rings, const MeetingCheck& checked, double facing, std::span<const Vec> peaks,
                 double d, ExactTips& tips);

}  // namespace firn::slice
