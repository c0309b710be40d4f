// Stretches of rings or of a front along which the next level is further away than it runs.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/vec.h"

namespace firn::slice {

/// Polylines, area on their left. All of a stretch's edges are walls; what lacks the next level lies between
/// its places `first` and `last` (points). Of a closed one all lacks it, and the last point joins the first.
struct Stretches {
  struct Stretch {
    std::uint32_t end = 0;              ///< index behind its last point
    std::uint32_t first = 0, last = 0;  ///< within its points
    bool closed = false;
    /// The nearest place of the next level is `ahead`, where the stretch's neighbours have a corner in it,
    /// and what is between there and the stretch has no other walls.
    bool cornered = false;
    Vec ahead;
    bool leads =
        false;  ///< it and those up to the next one that leads are of one area: others do not face them
  };
  std::vector<Vec> points;
  std::vector<Stretch> all;
  bool tips_moved = false;  ///< may the next level's corners have been drawn elsewhere?

  bool empty() const { return all.empty(); }
  void forget_corners() {
    for (Stretch& stretch : all) stretch.cornered = false;
  }
  void clear() {
    points.clear();
    all.clear();
  }
};

}  // namespace firn::slice
