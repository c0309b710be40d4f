// CellQuality holds the origin of a cell's height in a height map. The numbers are those of height_map_t.
#pragma once

#include <cstdint>

namespace firn {

enum class CellQuality : std::int8_t {
  kMeasured = 0,
  kGuessed = 1,          ///< no valid sample: filled from its neighbours
  kOutlierReplaced = 2,  ///< by its neighbours
};

}  // namespace firn
