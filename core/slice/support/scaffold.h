// scaffold_regions() computes the scaffold of all layers: RPSCAF [Barnett, 3.3].
#pragma once

#include <span>
#include <vector>

#include "core/geometry/region.h"
#include "core/grid/parallel.h"
#include "core/slice/paths/path_options.h"

namespace firn::slice {

/// Returns the scaffold of every layer. Full: (union of this layer and all above, grown outward by buffer_mm)
/// minus this layer [3.3]. The union includes this layer, since ice that widens downward by more than the
/// buffer would otherwise remain bare. Overhang: the areas above that exceed the layer below by more than
/// height x tan(overhang), down to the ground.
///
/// @param part regions of all parts together, bottom up; disjoint within a layer
/// @param height of one layer, units
/// @return one region per layer; all empty for Support::kNone
/// No scaffold point is further than buffer_mm from ice of its layer or above. Its outer edge may be at most
/// 4.5 chord tolerances short of that, for any number of layers (see tolerant_boolean.h).
std::vector<geometry::Region> scaffold_regions(std::span<const geometry::Region> part, std::int32_t height,
                                               const SupportOptions& options, double chord_tolerance_mm,
                                               const ParallelFor& parallel = serially);

}  // namespace firn::slice
