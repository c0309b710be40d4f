// OwnMessage is a message that a program of the lab's own may publish in a print; own_message() reads one
// from bytes that nobody has checked. The table of such channels: docs/own-lcm-program.md
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "firn/own_flow_model_t.hpp"
#include "firn/own_height_model_t.hpp"
#include "firn/own_values_t.hpp"
#include "lcmtypes/channels.h"

namespace firn {

using OwnMessage = std::variant<own_values_t, own_height_model_t, own_flow_model_t>;

inline const Channel<own_values_t>& channel_of(const own_values_t&) { return channels::kOwnValues; }
inline const Channel<own_height_model_t>& channel_of(const own_height_model_t&) {
  return channels::kOwnHeightModel;
}
inline const Channel<own_flow_model_t>& channel_of(const own_flow_model_t&) {
  return channels::kOwnFlowModel;
}

/// Names of the channels, in the order of OwnMessage.
std::span<const std::string_view> own_channels();

/// Returns the message of `program` in `bytes`, with its name in `program`. Its header may hold anything: the
/// launcher writes another one.
/// @throws std::invalid_argument naming the channel, the byte, the member and the limit
OwnMessage own_message(std::string_view program, std::string_view channel, std::span<const std::byte> bytes);

/// Returns the message of `program` that a JSON object holds (message_from_json.h).
/// @throws std::invalid_argument naming the channel, the member and the limit
OwnMessage own_message_from_json(std::string_view program, std::string_view channel, std::string_view json);

}  // namespace firn
