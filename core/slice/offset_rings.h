// The rings of a concentric fill, each the exact offset of the original outline [Barnett, 3.4, 3.5].
#pragma once

#include <cstdint>
#include <vector>

#include "core/slice/region.h"

namespace firn::slice {

/// Distances of the rings from the outline: boundaries first, then fill until nothing is left.
struct RingPlan {
  double first_mm = 0.6;           ///< outline to the outermost ring
  int boundaries = 1;
  double boundary_width_mm = 1.5;
  double fill_width_mm = 3.0;
  int max_rings = 1 << 20;         ///< levels, from the outside
  double distance_mm(int level) const {
    if (level < boundaries) return first_mm + level * boundary_width_mm;
    const double inside = boundaries ? first_mm + (boundaries - 0.5) * boundary_width_mm + 0.5 * fill_width_mm : first_mm;
    return inside + (level - boundaries) * fill_width_mm;
  }
  double width_mm(int level) const { return level < boundaries ? boundary_width_mm : fill_width_mm; }
};

struct RingLevels {
  std::vector<Rings> levels;        ///< [k]: all rings at distance_mm(k), directed as in a Region, in no canonical order
  std::uint32_t from_clipper = 0;   ///< levels that Clipper made, because the wavefront could not tell
  std::vector<bool> touching;       ///< [k]: rings of the level may have contacts with each other
  std::uint32_t drawn_finer = 0;    ///< levels whose rings would have met each other at the asked tolerance
};

/// @param tolerance_mm no ring leaves the exact offset of `region` by more than this; 0: arcs by 1 um, no point left out
RingLevels offset_rings(const Region& region, const RingPlan& plan, double tolerance_mm);

/// The region grown outward by a distance > 0, as the front of what lies around it.
Region grow(const Region& region, double outward_mm, double tolerance_mm);

/// Do any two edges have a point in common that is not the corner between neighbours (a contact), or even cross?
enum class Meeting { kApart, kContact, kCrossing };
Meeting meeting_of(const Rings& rings);

}  // namespace firn::slice
