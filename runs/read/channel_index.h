// ChannelIndex holds the numbers of channels; stamp_of reads the header at the start of a message without
// decoding the message.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <unordered_map>

#include "lcmtypes/channels.h"

namespace firn::runs {

/// Maps a channel's name to its position in channel_table().
class ChannelIndex {
 public:
  ChannelIndex();
  /// @returns -1 for a channel that the table does not hold.
  int find(std::string_view name) const;
  static std::size_t size() { return channel_table().size(); }

 private:
  std::unordered_map<std::string_view, int> numbers_;
};

/// Returns true for the runner's own messages: CONFIG_, HEARTBEAT_, RESEND_, JOURNAL_.
bool of_the_runner(const ChannelInfo& channel);

/// Returns true if replay knows the messages that the publisher sent on the channel. False for launcher and
/// recorder, which are not replayed, and for the runner's own messages (CONFIG_, HEARTBEAT_, RESEND_,
/// JOURNAL_).
bool sent_by_node(const ChannelInfo& channel);

/// Holds the header_t of an encoded message.
struct Stamp {
  std::int64_t run_id = 0;
  std::int32_t incarnation = 0;
  std::int64_t seq = 0;
  std::int64_t utime_us = 0;
};
/// Returns the stamp; empty if the bytes are too few to hold one.
std::optional<Stamp> stamp_of(std::span<const std::byte> message);

}  // namespace firn::runs
