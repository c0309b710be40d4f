// Transport makes LCM's UDP reliable, below the node: no LCM, no clock (wall time is handed in), no thread.
// Out: an encoded message -> datagrams. In: datagrams -> messages, in order, once, byte for byte as sent.
//
// Reliable channels: the sender keeps its messages; a receiver sees a gap by header.seq, a lost tail by the
// heartbeat's last_seq, and asks again by RESEND_<SELF> until it is filled. Latest channels: a stale message
// is dropped. Messages above wire::kLargestWholeBytes travel as tile_t on "<CHANNEL>_TILES".
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "lcmtypes/channels.h"

namespace firn {

class TransportReceiver;
class TransportSender;

struct TransportOptions {
  NodeId self = NodeId::kScheduler;
  std::int64_t run_id = 0;
  std::int32_t incarnation = 0;
  std::size_t ring_bytes = std::size_t(64)
                           << 20;  ///< sent messages kept in memory; older ones come from `fetch`
  std::size_t window_bytes = std::size_t(64)
                             << 20;    ///< received out of order or in pieces, over all channels
  std::int64_t patience_us = 5'000;    ///< a gap may be mere reordering for so long
  std::int64_t ask_again_us = 20'000;  ///< doubles up to 16 times this while nothing comes
  std::int64_t tile_gap_us = 200;      ///< between full tiles, in the mean
  std::size_t burst_bytes = 0;         ///< of tiles that may leave without a gap after a pause

  /// A quarter of the bytes that may wait for a busy receiver: several senders may speak at the same time.
  static std::size_t burst_into(std::size_t receive_buffer_bytes) { return receive_buffer_bytes / 4; }
};

struct TransportStats {
  std::uint64_t delivered = 0;
  std::uint64_t datagrams_in = 0;
  std::uint64_t bytes_in = 0;
  std::uint64_t duplicates = 0;  ///< reliable: seen before
  std::uint64_t stale = 0;       ///< latest: older than the message handed on
  std::uint64_t foreign = 0;     ///< another run's, or an incarnation that cannot be
  std::uint64_t malformed = 0;   ///< or with numbers that cannot follow (jump_check.h)
  std::uint64_t missing = 0;     ///< messages that were found missing
  std::uint64_t requests = 0;    ///< RESEND messages sent
  std::uint64_t resent = 0;      ///< messages sent again for others
};

class Transport {
 public:
  /// Called with each message for the node; the bytes are valid during the call only.
  using Deliver = std::function<void(const ChannelInfo&, std::span<const std::byte>)>;
  /// Finds the encoded message (channel, seq) in the own write-ahead file. False if it is not there.
  using Fetch = std::function<bool(std::string_view channel, std::int64_t seq, std::vector<std::byte>& to)>;

  Transport(const TransportOptions& options, Deliver deliver, Fetch fetch = {});
  ~Transport();

  /// @throws std::invalid_argument for an unknown channel
  void subscribe(std::string_view channel);
  /// Channels that the bus must listen to: those subscribed, their tiles, requests, and the heartbeats of
  /// those who publish them reliably. A process sleeps through all other messages.
  std::vector<std::string> wire_channels() const;

  // After a resume, before anything else: the messages that were sent and handled according to the
  // write-ahead file. @throws std::runtime_error naming one that no process of this run can have sent
  void restore_sent(std::string_view channel, std::span<const std::byte> message);
  void restore_received(std::string_view channel, std::span<const std::byte> message);

  /// Takes an encoded message whose header carries the next seq of `channel`. @throws std::logic_error
  /// otherwise.
  void send(std::string_view channel, std::span<const std::byte> message, std::int64_t wall_us);

  struct Datagram {
    std::string_view channel;
    std::span<const std::byte> bytes;  ///< valid until the next call of next_datagram
  };
  /// The next datagram that may leave at `wall_us`. False when there is none.
  bool next_datagram(std::int64_t wall_us, Datagram& out);
  std::size_t backlog_bytes() const;

  /// Any bytes: malformed ones are counted, named and dropped.
  void receive(std::string_view channel, std::span<const std::byte> datagram, std::int64_t wall_us);
  /// Asks for missing messages, if it is time to.
  void tick(std::int64_t wall_us);
  /// Wall time at which next_datagram or tick has something to do; INT64_MAX = nothing waits.
  std::int64_t due_us(std::int64_t wall_us) const;

  /// Last sequence number of each reliable channel that was sent: for the heartbeat.
  struct Last {
    std::string_view channel;
    std::int64_t seq;
  };
  std::vector<Last> last_sent() const;
  /// Last sequence number handed on; 0 = none.
  std::int64_t last_delivered(std::string_view channel) const;
  /// Whether some message that is known to exist has not come yet.
  bool waiting() const;

  TransportStats stats() const;
  /// Each kind of trouble once, as a sentence.
  std::vector<std::string> take_notices();

 private:
  TransportOptions options_;
  std::unique_ptr<TransportReceiver> receiver_;
  std::unique_ptr<TransportSender> sender_;
  std::int64_t request_seq_ = 0;
};

}  // namespace firn
