// map_head reads the front of a height map's message, not its cells.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "firn/grid_t.hpp"

namespace firn::page {

struct MapHead {
  std::int64_t utime_us = 0;
  int layer = 0;
  grid_t grid{};
};

/// @param message an encoded height_map_t. @returns nothing for another message
std::optional<MapHead> map_head(std::span<const std::byte> message);

}  // namespace firn::page
