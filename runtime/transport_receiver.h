// TransportReceiver holds the receiving half of Transport: order, gaps, tiles, requests for missing messages.
// Used by transport.cpp only.
#pragma once

#include <map>
#include <set>

#include "runtime/jump_check.h"
#include "runtime/transport.h"
#include "runtime/transport_wire.h"

namespace firn {

class TransportReceiver {
 public:
  TransportReceiver(const TransportOptions& options, Transport::Deliver deliver);

  void subscribe(const ChannelInfo& row);
  std::vector<std::string> wire_channels() const;
  /// Those whose heartbeats tell what is missing.
  std::set<NodeId> reliable_publishers() const;
  /// @throws std::runtime_error for a message that no process of this run can have sent
  void restore(std::string_view channel, std::span<const std::byte> message);

  /// A message or tile on a subscribed channel; false if the channel is not subscribed.
  bool receive(std::string_view channel, std::span<const std::byte> datagram, std::int64_t wall_us);
  void heartbeat(std::span<const std::byte> message, const NodeInfo& publisher, std::int64_t wall_us);
  /// The ranges of messages to ask for again at this time; empty before the next question is due.
  std::vector<wire::SeqRange> to_ask(std::int64_t wall_us);
  std::int64_t due_us() const;

  bool foreign(std::int64_t run_id, std::int32_t incarnation, std::string_view channel);
  void malformed(std::string_view channel, std::string_view why);

  std::int64_t last_delivered(std::string_view channel) const;
  bool waiting() const;
  TransportStats stats;
  std::vector<std::string> notices;

 private:
  struct Partial {  // an object in pieces
    std::int32_t incarnation = 0;
    std::int64_t total_bytes = 0;
    std::uint64_t checksum = 0;
    std::int64_t last_us = 0;
    std::int32_t have = 0;
    std::vector<std::vector<std::byte>> tiles;
  };
  struct In {
    const ChannelInfo* row = nullptr;
    bool reliable = false;
    std::int64_t delivered = 0;
    std::int32_t incarnation = 0;  // of the last delivered
    std::int64_t known = 0;        // highest seq that is known to exist
    std::int64_t counted = 0;      // missing ones up to here are in stats.missing
    std::int64_t quiet_us = 0;     // since when the next one is awaited
    std::int64_t asked_us = 0;
    int asked_times = 0;  // since something came
    std::map<std::int64_t, std::vector<std::byte>> ahead;
    std::map<std::int64_t, Partial> partial;
  };

  void whole(In& in, std::span<const std::byte> message, std::int64_t wall_us);
  void tile(In& in, std::span<const std::byte> datagram, std::int64_t wall_us);
  void accept(In& in, const wire::Header& header, std::span<const std::byte> message, std::int64_t wall_us);
  /// False for a message whose numbers cannot follow: its place stays free for the one that was sent.
  bool hand_on(In& in, const wire::Header& header, std::span<const std::byte> message);
  bool follows(const In& in, const wire::Header& header, std::span<const std::byte> message);
  /// Whether (incarnation, seq) is new for the channel and plausible; keeps count.
  bool wanted(In& in, std::int32_t incarnation, std::int64_t seq, std::int64_t wall_us);
  void know(In& in, std::int64_t seq, std::int64_t wall_us);
  void forget_partial(In& in, std::map<std::int64_t, Partial>::iterator it);
  std::int64_t ask_at(const In& in) const;
  void notice_once(std::string key, std::string text);

  TransportOptions options_;
  Transport::Deliver deliver_;
  std::map<std::string, In, std::less<>> in_;
  std::map<std::string, In*, std::less<>> tiles_;
  JumpCheck jumps_;
  std::size_t held_bytes_ = 0;
  std::set<std::string> noticed_;
};

}  // namespace firn
