// integrate_increments() computes the heights of a layer-wise record from its increments, and bridges cells
// whose increment is missing.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/grid/grid.h"

namespace firn {

struct IntegratedHeights {
  std::vector<HeightMap> heights;  ///< [layer] [mm]; kNotMeasured: no increment from there on, or none at all
  std::vector<Mask> bridged;       ///< [layer], 1 where the layer's increment is interpolated
  std::int64_t bridges = 0;        ///< cells of `bridged` above the base
  int base = 0;                    ///< layer whose surface the heights are counted from
};

bool has_value(const Grid<double>& values);

/// Returns the layer under the first one with an increment: 0 where layer 0 has some. None: no increment at
/// all.
std::optional<int> base_layer(const std::vector<HeightMap>& increments);

/// Sums increments from the first layer that has any. A missing increment of a cell that is known in a later
/// layer is bridged: interpolated linearly along x between the layer's known cells (the nearest one beyond
/// the last), in a row without any by the layer's mean, in a layer without any linearly between the layers
/// before and after.
/// @param increments [layer] [mm], kNotMeasured where missing @pre base_layer() has one
/// @param ground height of the base layer [mm]; layers up to it count as bridged, but for layer 0
IntegratedHeights integrate_increments(std::vector<HeightMap> increments, const HeightMap& ground);

/// Fills cells without a value as above, from their row or else from the mean. Does nothing without any
/// value.
void fill_along_x(Grid<double>& values);

}  // namespace firn
