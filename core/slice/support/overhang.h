// for_overhanging() computes the overhanging areas of all layers and their projection to the layers below,
// down to the part.
#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "core/geometry/region.h"
#include "core/grid/parallel.h"

namespace firn::slice {

struct OverhangOptions {
  double lean_mm = 0.25;  ///< distance by which a layer may exceed the one below
  double seam_mm = 1.0;   ///< margin of the supported area, which joins areas close to each other; 0: exact
  double tolerance_mm = 0.05;  ///< of the drawing of lean and seam
};

/// Calls use(k, need) for every layer k from the top, in any thread. `need` is the area of the layers above k
/// that exceeds the layer below it by more than lean_mm and has no part between it and layer k, grown by
/// seam_mm.
///
/// Overhanging surfaces are supported as a whole: each layer contributes all of its area within lean of the
/// parts that exceed it, and the seam around that. The narrow strips of the layers of a slope so join, and
/// few points are carried down. No overhang is lost; the area exceeds the projection of the layers above by
/// at most seam_mm. Where it comes down on the part, a margin of the seam remains beside walls within that
/// distance.
void for_overhanging(std::span<const geometry::Region> part, const OverhangOptions& options,
                     const ParallelFor& parallel,
                     const std::function<void(std::size_t k, const geometry::Region& need)>& use);

}  // namespace firn::slice
