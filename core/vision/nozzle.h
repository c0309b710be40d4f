// Nozzle measures the edge and the width of the object that reaches the picture's edge.
#pragma once

#include "core/vision/bulges.h"

namespace firn::vision {

struct Nozzle {
  bool found = false;
  Point edge;                                 ///< middle of the edge [px]
  double edge_std_px = 0.0;                   ///< along the flight
  double width_px = 0.0, width_std_px = 0.0;  ///< across the flight, near the edge
  Point flight;                               ///< unit vector from the nozzle's side of the picture inwards
};

/// Follows both flanks of the silhouette from its side of the picture inwards; dirt over them is passed
/// over. It ends where less than half of what is between them is covered. @pre the component reaches the
/// picture's edge
Nozzle measure_nozzle(const Scene& scene, const Component& component);

}  // namespace firn::vision
