// nested_groups() finds the connected areas of a region.
#pragma once

#include <cstdint>
#include <vector>

#include "core/geometry/region.h"

namespace firn::geometry {

/// Returns per outer ring its number, followed by those of its holes. Holes that no outer ring contains are
/// left out.
std::vector<std::vector<std::uint32_t>> nested_groups(const Region& region);

}  // namespace firn::geometry
