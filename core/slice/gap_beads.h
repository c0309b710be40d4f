// Beads for what the rings of a concentric fill leave uncovered: their middle lines, as wide as the gap is there.
#pragma once

#include <cstdint>
#include <memory>
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
  double inside_mm = 0.0;   ///< so far the rings that are given lie inward of that level
};
/// @param level of the outer rings; -1: the outline itself, whose wanted area is that of coverage.h
GapBand gap_band(const RingPlan& plan, int level);
/// The same from a level's cores (RingPlan::core_mm) on: every disc of that diameter touches what is covered there.
GapBand core_band(const RingPlan& plan, int level, double spot_mm);

/// Beads on the medial axis of the area between two levels, where it is narrower than the next level's bead is wide, or
/// where that bead does not reach. Let rho be the axis' distance from the covered edge: all of a spot that is uncovered lies
/// in a disc of radius rho about some place of the axis, and a bead 2 rho wide covers it. Sections of an axis whose rho
/// differs by less than a third are one bead, as wide as the widest of it.
///
/// Spots that no circle of diameter `narrowest_mm` fits into stay: tips of corners, mostly.
/// @param outer, next the rings of both levels; `next` may be empty
/// @param touching whether rings of `outer` may have contacts other than common corners
/// Keeps its working memory.
class GapFinder {
 public:
  GapFinder();
  ~GapFinder();
  Beads operator()(const Rings& outer, const Rings& next, const GapBand& band, double narrowest_mm, double tolerance_mm,
                   bool touching = false);

 private:
  class Work;
  std::unique_ptr<Work> work_;
};

}  // namespace firn::slice
