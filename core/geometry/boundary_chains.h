// BoundaryChains holds the parts of an outline or a wavefront from which the next offset level is too far
// away.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/vec.h"

namespace firn::geometry {

/// Polylines with the area on their left. All edges of a chain are boundary segments; the part without the
/// next level lies between its points `first` and `last`. In a closed chain that is all of it, and the last
/// point joins the first.
struct BoundaryChains {
  struct Chain {
    std::uint32_t end = 0;              ///< index behind its last point
    std::uint32_t first = 0, last = 0;  ///< within its points
    bool closed = false;
    /// `ahead` is the nearest point of the next level: the corner in which the neighbours of the chain meet
    /// there. No other boundary segment lies between it and the chain.
    bool cornered = false;
    Vec ahead;
    /// The chain and those behind it, up to the next one with this flag, bound one area; chains of other
    /// areas do not face them.
    bool leads = false;
  };
  std::vector<Vec> points;
  std::vector<Chain> all;
  bool cusps_moved = false;  ///< the corners of the next level may have been corrected

  bool empty() const { return all.empty(); }
  void forget_corners() {
    for (Chain& chain : all) chain.cornered = false;
  }
  void clear() {
    points.clear();
    all.clear();
  }
};

}  // namespace firn::geometry
