// Checks between the files of a run.
#pragma once

#include <filesystem>
#include <vector>

#include "replay/node_replay.h"

namespace firn::replay {

/// All that was sent, by channel; looked up by sequence number.
class SentIndex {
 public:
  explicit SentIndex(const std::vector<NodeOutcome>& nodes);
  const Sent* find(int channel, std::int64_t seq) const;
  /// Whether the file of the channel's publisher was read.
  bool knows(int channel) const { return publishers_[std::size_t(channel)] != nullptr; }
  const std::vector<Sent>& all(int channel) const;
  /// The step of the publisher's file before which the message `seq`, which the file lacks, must have been
  /// sent.
  std::uint64_t step_after(int channel, std::int64_t seq) const;

 private:
  std::vector<const NodeOutcome*> publishers_;  // by ChannelIndex
};

/// Every delivered message must be what its publisher's file holds, and none may be left out.
void check_deliveries(const SentIndex& sent, std::vector<NodeOutcome>& nodes, MessageComparer& comparer);

}  // namespace firn::replay
