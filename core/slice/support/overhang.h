// What hangs over, and where nothing of the part stands below it yet.
#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "core/grid/parallel.h"
#include "core/geometry/region.h"

namespace firn::slice {

struct OverhangOptions {
  double lean_mm = 0.25;  ///< a layer may reach further out than the one below by this much
  double seam_mm =
      1.0;  ///< need is carried so much wider, so that what lies close together is one; 0: exactly
  double tolerance_mm = 0.05;  ///< to which lean and seam are drawn
};

/// Calls use(k, need) for every layer k from the top, in any thread: what of the layers above k leans out
/// further than lean_mm over the layer below it and has no part between it and layer k, seam_mm wider.
///
/// Surfaces that lean out are taken whole: each layer brings all of it that lies within lean of what leans
/// out too far, and the seam around that. The narrow strips of the layers of a slope join so, and few points
/// are carried down. Nothing that hangs over is lost; the need reaches no further than seam_mm beyond the
/// projection of what is above. Where it comes down on part, the seam's width goes on beside a wall that is
/// no further than that from what has come down.
void for_overhanging(std::span<const Region> part, const OverhangOptions& options,
                     const ParallelFor& parallel,
                     const std::function<void(std::size_t k, const Region& need)>& use);

}  // namespace firn::slice
