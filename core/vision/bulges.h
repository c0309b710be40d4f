// Bulges divides a silhouette at its necks: nozzle, ligament beads, heads of droplets.
#pragma once

#include <cstdint>
#include <vector>

#include "core/vision/scene.h"

namespace firn::vision {

/// A silhouette on a lattice of cells of `scale` pixels, holes filled. Cell (i, j) covers pixels from
/// x0 + i * scale, y0 + j * scale.
struct Silhouette {
  int x0 = 0, y0 = 0, scale = 1, columns = 0, rows = 0;
  bool left = false, top = false, right = false, bottom = false;  ///< this side lies on the picture's edge
  std::vector<std::uint8_t> mask;

  bool at(int i, int j) const {
    return i >= 0 && j >= 0 && i < columns && j < rows &&
           mask[std::size_t(j) * std::size_t(columns) + std::size_t(i)];
  }
};

/// @param level opacity of the outline; @param cells limit of the lattice's size
Silhouette make_silhouette(const Scene& scene, const Component& component, double level, int cells);

struct Bulge {
  double x = 0.0, y = 0.0;  ///< centroid of the core [px of the picture]
  double radius_px = 0.0;   ///< of the largest inscribed circle
  double reach_px = 0.0;  ///< farthest part of the bulge from the core's border: a tail, if above the radius
  double elongation = 1.0;  ///< axes of the core, opened out by its distance from the outline
  bool at_edge = false;     ///< the core reaches the picture's edge: a nozzle or a droplet that is cut off
};

/// Peaks of the distance to the outline, with a bulge each; two peaks share a bulge when the neck between
/// them is wider than `neck` times the smaller. The picture's edge is no outline. The largest comes first.
std::vector<Bulge> find_bulges(const Silhouette& silhouette, double neck = 0.78);

}  // namespace firn::vision
