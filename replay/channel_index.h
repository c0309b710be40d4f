// Numbers for channels, and the header that stands first in every message, read without decoding the message.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <unordered_map>

#include "lcmtypes/channels.h"

namespace firn::replay {

/// Position of a channel in channel_table().
class ChannelIndex {
 public:
  ChannelIndex();
  /// @returns -1 for a channel that the table does not hold.
  int find(std::string_view name) const;
  static std::size_t size() { return channel_table().size(); }

 private:
  std::unordered_map<std::string_view, int> numbers_;
};

/// Whether replay knows what the publisher sent there: not for launcher and recorder, which stand outside
/// replay, nor for what the runner sends on its own (CONFIG_, HEARTBEAT_, RESEND_, JOURNAL_).
bool sent_by_node(const ChannelInfo& channel);

/// header_t of an encoded message.
struct Stamp {
  std::int64_t run_id = 0;
  std::int32_t incarnation = 0;
  std::int64_t seq = 0;
  std::int64_t utime_us = 0;
};
/// Empty if the bytes are too few to hold one.
std::optional<Stamp> stamp_of(std::span<const std::byte> message);

}  // namespace firn::replay
