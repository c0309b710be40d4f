// Rows of channels.table as the generator writes them. For channels.cpp.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "lcmtypes/channels.h"

namespace firn {

/// One row for each node of a kind: ANSWER_STAGE, ANSWER_JET, …
struct ChannelFamily {
  enum Publisher : std::uint8_t { kAny, kDrivers, kReplayed };

  std::string_view prefix, type;
  Publisher publisher;
  Delivery delivery;
  double rate_hz;
  int queue;
  bool logged;
  std::string_view meaning;
  bool nodes_may_read;
};

std::span<const ChannelInfo> shared_channels();
std::span<const ChannelFamily> channel_families();

}  // namespace firn
