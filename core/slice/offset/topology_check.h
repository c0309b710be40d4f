// check_topology() finds the places where the rings of a simplified outline may bound other areas than those
// of its contours.
#pragma once

#include <span>

#include "core/geometry/intersection.h"
#include "core/slice/offset/cusp_corrector.h"

namespace firn::slice {

/// Examines narrow passages and small areas: sides whose distance differs from 2 d by less than twice the
/// simplification, or an area with hardly room for a disc of radius d, may be closed for one and open for the
/// other.
/// @param rings at distance d; `checked` lists those of their edges that face each other within `facing`
/// @param peaks local maxima of the distance from the simplified outline, within the simplification of d
void check_topology(const geometry::Rings& rings, const geometry::IntersectionCheck& checked, double facing,
                    std::span<const geometry::Vec> peaks, double d, CuspCorrector& cusps);

}  // namespace firn::slice
