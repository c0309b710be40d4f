// Beads for what the rings of a concentric fill leave uncovered: their middle lines, as wide as the gap is there.
#pragma once

#include <cstdint>
#include <vector>

#include "core/slice/offset_rings.h"

namespace firn::slice {

/// Open lines of their own widths, in units.
struct Beads {
  Rings lines;
  std::vector<std::int32_t> widths;
};

/// What lies between one level of rings (or the outline) and the next, in mm inward of the former.
struct GapBand {
  double covered_mm = 0.0;  ///< so far the beads of the outer level reach; < 0: the wanted area begins outside the outline
  double next_mm = 0.0;     ///< there the next level runs, half as wide a bead as is left: next_mm - covered_mm to each side
};
/// @param level of the outer rings; -1: the outline itself, whose wanted area is that of coverage.h
GapBand gap_band(const RingPlan& plan, int level);

/// Beads on the medial axis of the area between two levels, where it is narrower than the next level's bead is wide, or
/// where that bead does not reach. Let rho be the axis' distance from the covered edge: all of a spot that is uncovered lies
/// in a disc of radius rho about some place of the axis, and a bead 2 rho wide covers it. Sections of an axis whose rho
/// differs by less than a third are one bead, as wide as the widest of it.
///
/// Spots that no circle of diameter `narrowest_mm` fits into stay: tips of corners, mostly.
/// @param outer, next the rings of both levels; `next` may be empty
/// @param touching whether rings of `outer` may have contacts other than common corners
Beads gap_beads(const Rings& outer, const Rings& next, const GapBand& band, double narrowest_mm, double tolerance_mm,
                bool touching = false);

}  // namespace firn::slice
