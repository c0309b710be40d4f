// Beads for what the rings of a concentric fill leave uncovered: their middle lines, as wide as the gap is
// there.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/geometry/stretches.h"
#include "core/slice/medial/gap_band.h"

namespace firn::slice {

/// Open lines of their own widths, in units.
struct Beads {
  Rings lines;
  std::vector<std::int32_t> widths;
};

/// Beads on the medial axis of the area between two levels, where it is narrower than the next level's bead
/// is wide, or where that bead does not reach. Let rho be the axis' distance from the covered edge: all of a
/// spot that is uncovered lies in a disc of radius rho about some place of the axis, and a bead 2 rho wide
/// covers it. Sections of an axis whose rho differs by less than a third are one bead, as wide as the widest
/// of it.
///
/// Spots that no circle of diameter `narrowest_mm` fits into stay: tips of corners, mostly.
/// @param outer, next the rings of both levels; `next` may be empty
/// @param touching whether rings of `outer` may have contacts other than common corners
/// Beads are appended. Keeps its working memory.
class GapFinder {
 public:
  GapFinder();
  ~GapFinder();
  void operator()(const Rings& outer, const Rings& next, const GapBand& band, double narrowest_mm,
                  double tolerance_mm, bool touching, Beads& beads);
  /// @param lacking what of the outer level lacks the next one (RingLevels::gaps); used up
  void operator()(Stretches& lacking, const Rings& next, const GapBand& band, double narrowest_mm,
                  double tolerance_mm, Beads& beads);

 private:
  class Work;
  std::unique_ptr<Work> work_;
};

}  // namespace firn::slice
