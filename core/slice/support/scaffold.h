// RPSCAF: where the scaffold stands [Barnett, 3.3].
#pragma once

#include <span>
#include <vector>

#include "core/grid/parallel.h"
#include "core/slice/paths/path_options.h"
#include "core/geometry/region.h"

namespace firn::slice {

/// Scaffold of every layer. Full: (union of this layer and all above, grown outward by buffer_mm) minus this
/// layer [3.3]. This layer belongs to the union, else ice that widens downward by more than the buffer would
/// stand bare. Overhang: what lies above and leans out further than height x tan(overhang) per layer, down to
/// the ground.
///
/// @param part   of all parts together, bottom up; not overlapping within a layer
/// @param height of one layer, units
/// @return one region per layer; all empty for Support::kNone
/// No scaffold point is further than buffer_mm from ice of its layer or above; its outer edge may fall short
/// of that by at most 4.5 chord tolerances, whatever the number of layers (see merge.h).
std::vector<Region> scaffold_regions(std::span<const Region> part, std::int32_t height,
                                     const SupportOptions& options, double chord_tolerance_mm,
                                     const ParallelFor& parallel = serially);

}  // namespace firn::slice
