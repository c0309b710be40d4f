// TransportSender holds the sending half of Transport: rings of sent messages, tiles, pacing, resends. Used
// by transport.cpp only.
#pragma once

#include <deque>
#include <map>
#include <memory>

#include "runtime/transport.h"
#include "runtime/transport_wire.h"

namespace firn {

class TransportSender {
 public:
  TransportSender(const TransportOptions& options, Transport::Fetch fetch);

  void restore(std::string_view channel, std::span<const std::byte> message);
  void send(std::string_view channel, std::span<const std::byte> message);
  /// Messages of the transport itself (requests): not kept.
  void send_once(std::string_view channel, std::vector<std::byte> message);
  void resend(const wire::SeqRange& range, std::int64_t wall_us);
  bool next(std::int64_t wall_us, Transport::Datagram& out);
  std::int64_t due_us(std::int64_t wall_us) const;
  std::size_t backlog_bytes() const { return backlog_bytes_; }
  std::vector<Transport::Last> last_sent() const;
  std::uint64_t resent() const { return resent_; }

 private:
  using Bytes = std::shared_ptr<const std::vector<std::byte>>;
  struct Sent {
    std::int64_t seq;
    Bytes bytes;
    std::int64_t resent_us;
  };
  struct Ring {
    std::string_view name;
    std::string tiles_name;
    bool reliable = false;
    std::int64_t last = 0;
    std::deque<Sent> sent;  // consecutive seq
  };
  struct Waiting {
    const Ring* ring;
    Bytes bytes;
    std::int32_t tile = -1;  // -1 = the whole message
    std::uint64_t checksum = 0;
  };

  Ring& ring(std::string_view channel);
  Bytes keep(Ring& r, std::span<const std::byte> message);
  void queue(const Ring& r, Bytes bytes, bool again);
  /// The time that so many bytes take at the pace.
  std::int64_t gap_us(std::size_t bytes) const;

  TransportOptions options_;
  Transport::Fetch fetch_;
  std::map<std::string_view, Ring> rings_;
  std::deque<Ring*> order_;  // of the kept messages, oldest first
  std::size_t kept_bytes_ = 0;
  std::deque<Waiting> at_once_, paced_;
  std::size_t backlog_bytes_ = 0;
  std::int64_t paced_ready_us_ = 0;  // no paced message leaves before
  Waiting current_;
  std::vector<std::byte> current_tile_;
  std::uint64_t resent_ = 0;
};

}  // namespace firn
