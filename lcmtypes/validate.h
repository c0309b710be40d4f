// validate() checks whether a node may act on a received message: form first (schema.h), then the range of
// every member, from one table by member path. Called on every message that reaches a node.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "lcmtypes/channels.h"

namespace firn {

/// @returns nothing if `message` is whole and within its limits, else one line that names channel, byte,
/// member, value
///          and limit: "LAYER_PLAN: byte 36: grid.nx = 0 is outside 1..4096".
std::optional<std::string> validate(const ChannelInfo& channel, std::span<const std::byte> message);
/// The same for a message outside the channel table (tile_t). @param type "tile_t"
std::optional<std::string> validate(std::string_view channel, std::string_view type,
                                    std::span<const std::byte> message);

}  // namespace firn
