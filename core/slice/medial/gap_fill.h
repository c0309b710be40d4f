// GapFiller computes extrusion lines for the areas that the rings of a concentric fill leave uncovered.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/geometry/boundary_chains.h"
#include "core/slice/medial/gap_band.h"

namespace firn::slice {

/// Open lines, each with its own width, in units.
struct ExtrusionLines {
  geometry::Rings lines;
  std::vector<std::int32_t> widths;
};

/// Places lines on the medial axis of the area between two levels, where it is narrower than the lines of the
/// next level or beyond their reach. Let rho be the distance of the axis from the covered edge: a void lies
/// in a disc of radius rho about some point of the axis, and a line of width 2 rho covers it. Parts of a
/// branch whose rho differs by less than a third are one line, as wide as its maximum.
///
/// Voids without room for a circle of diameter `narrowest_mm` remain: mostly cusps of corners.
/// @param outer, next the rings of both levels; `next` may be empty
/// @param touching whether rings of `outer` may have contacts other than common corners
/// Lines are appended. Keeps its working memory.
class GapFiller {
 public:
  GapFiller();
  ~GapFiller();
  void operator()(const geometry::Rings& outer, const geometry::Rings& next, const GapBand& band,
                  double narrowest_mm, double tolerance_mm, bool touching, ExtrusionLines& extrusions);
  /// @param uncovered the chains of the outer level without a next level (RingLevels::gaps); consumed
  void operator()(geometry::BoundaryChains& uncovered, const geometry::Rings& next, const GapBand& band,
                  double narrowest_mm, double tolerance_mm, ExtrusionLines& extrusions);

 private:
  class Work;
  std::unique_ptr<Work> work_;
};

}  // namespace firn::slice
