// Adds a layer to the union of those above it, as far as it sticks out; takes one away, as far as it cuts in.
#pragma once

#include "core/geometry/region.h"

namespace firn::slice {

/// `above` with those parts of `layer` that reach out of it by more than `slack` units. What sticks out less
/// is left for a later layer to bring: the result never reaches beyond the true union and lacks at most a rim
/// of `slack`, however many layers follow each other, since each is held against what is there and not
/// against the layer before.
///
/// Both are Regions but for crossings by less than a unit; so is the result. Crossings are found and ordered
/// exactly, as if `layer` were moved by an infinitesimal step, so that coinciding outlines need no case of
/// their own. Where the outlines contradict each other all the same, the exact overlay unites them.
Region merge_protruding(const Region& above, const Region& layer, std::int32_t slack);

/// `region` without `taken`, by the same machinery: what reaches into the region by no more than `slack`
/// stays in it.
Region without(const Region& region, const Region& taken, std::int32_t slack);
/// What both have in common; where one reaches beyond the other by no more than `slack`, that may be left in.
Region within_both(const Region& region, const Region& bound, std::int32_t slack);

}  // namespace firn::slice
