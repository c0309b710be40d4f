// union_within() computes unions, differences and intersections of regions within a tolerance.
#pragma once

#include "core/geometry/region.h"

namespace firn::geometry {

/// Returns `above` with those parts of `layer` that protrude from it by more than `tolerance` units. Smaller
/// parts are left to later layers. The result never exceeds the true union and lacks at most a rim of
/// `tolerance`, for any number of layers, since each layer is compared with the union and not with the layer
/// before.
///
/// Both operands are Regions except for crossings by less than a unit, and so is the result. Crossings are
/// found and ordered exactly by symbolic perturbation: `layer` is moved by an infinitesimal step, so that
/// coinciding outlines are no special case. Where the outlines are inconsistent nevertheless, the exact
/// overlay computes the union.
Region union_within(const Region& above, const Region& layer, std::int32_t tolerance);

/// Returns the difference by the same method. Parts of `taken` that reach into the region by at most
/// `tolerance` remain in the result.
Region difference_within(const Region& region, const Region& taken, std::int32_t tolerance);
/// Returns the intersection by the same method. Parts of one region that exceed the other by at most
/// `tolerance` may remain.
Region intersection_within(const Region& region, const Region& bound, std::int32_t tolerance);

}  // namespace firn::geometry
