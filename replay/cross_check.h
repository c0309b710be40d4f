// Checks the deliveries between the nodes' files of a run.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "replay/node_replay.h"

namespace firn::replay {

/// Holds all sent messages by channel and finds them by sequence number.
class SentIndex {
 public:
  explicit SentIndex(const std::vector<NodeOutcome>& nodes);
  /// Returns a message that is valid until the next look at its channel; nullptr: the file has none.
  const Sent* find(int channel, std::int64_t seq) const;
  /// Returns its position in all(); nothing: the file has no such message.
  std::optional<std::size_t> position(int channel, std::int64_t seq) const;
  /// Returns the message at such a position, valid as that of find().
  const Sent& at_place(int channel, std::size_t place) const;
  /// Returns true if the file of the channel's publisher was read.
  bool knows(int channel) const { return publishers_[std::size_t(channel)] != nullptr; }
  /// Returns nullptr for a channel that it does not know.
  const SentList* all(int channel) const;
  /// Returns the step of the publisher's file before which the message `seq`, absent from the file, must have
  /// been sent.
  std::uint64_t step_after(int channel, std::int64_t seq) const;

 private:
  std::vector<const NodeOutcome*> publishers_;  // by ChannelIndex
};

/// Checks that every delivered message equals the message in its publisher's file, and that no message is
/// left out.
void check_deliveries(const SentIndex& sent, std::vector<NodeOutcome>& nodes, MessageComparer& comparer);

}  // namespace firn::replay
