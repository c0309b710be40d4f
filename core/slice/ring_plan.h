// RingPlan holds the distances from the outline at which the rings of a concentric fill run [Barnett, 3.5,
// 3.7].
#pragma once

namespace firn::slice {

/// Distances of the rings from the outline: boundaries first, then fill rings until the area is full.
struct RingPlan {
  double first_mm = 0.6;  ///< outline to the outermost ring
  int boundaries = 1;
  double boundary_width_mm = 1.5;
  double fill_width_mm = 3.0;
  int max_rings = 1 << 20;  ///< levels, from the outside
  double distance_mm(int level) const {
    if (level < boundaries) return first_mm + level * boundary_width_mm;
    const double inside =
        boundaries ? first_mm + (boundaries - 0.5) * boundary_width_mm + 0.5 * fill_width_mm : first_mm;
    return inside + (level - boundaries) * fill_width_mm;
  }
  double width_mm(int level) const { return level < boundaries ? boundary_width_mm : fill_width_mm; }
  /// Returns the distance of the eroded core of a level: the centres of discs of a diameter that touch the
  /// inner edge of the extrusion lines of the level.
  double eroded_core_mm(int level, double void_mm) const {
    return distance_mm(level) + 0.5 * width_mm(level) + 0.5 * void_mm;
  }
};

}  // namespace firn::slice
