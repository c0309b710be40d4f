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
  /// There discs of a diameter have their centres that touch the inner edge of a level's beads.
  double core_mm(int level, double spot_mm) const { return distance_mm(level) + 0.5 * width_mm(level) + 0.5 * spot_mm; }
};

/// Areas within a level's rings that are about too narrow for the next level: most of what no bead covers lies in them.
struct NarrowAreas {
  std::vector<bool> outer;  ///< [ring of the level]: bounds one of them; empty: there are none
  std::vector<bool> next;   ///< [ring of the next level]: lies in one of them
  Rings cores;              ///< their rings at core_mm(level)
  bool touching = false;    ///< the cores may have contacts with each other
};

struct RingLevels {
  std::vector<Rings> levels;        ///< [k]: all rings at distance_mm(k), directed as in a Region, in no canonical order
  std::uint32_t from_clipper = 0;   ///< levels that Clipper made, because the wavefront could not tell
  std::vector<bool> touching;       ///< [k]: rings of the level may have contacts with each other
  std::vector<NarrowAreas> narrow;  ///< [k], if asked for
  std::uint32_t drawn_finer = 0;    ///< levels whose rings would have met each other at the asked tolerance
};

/// @param tolerance_mm no ring leaves the exact offset of `region` by more than this; 0: arcs by 1 um, no point left out
/// @param spot_mm diameter of the spots that are looked for in narrow areas; 0: none
RingLevels offset_rings(const Region& region, const RingPlan& plan, double tolerance_mm, double spot_mm = 0);

/// The region grown outward by a distance > 0, as the front of what lies around it.
Region grow(const Region& region, double outward_mm, double tolerance_mm);

/// Do any two edges have a point in common that is not the corner between neighbours (a contact), or even cross?
enum class Meeting { kApart, kContact, kCrossing };
Meeting meeting_of(const Rings& rings);

}  // namespace firn::slice
