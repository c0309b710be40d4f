// TwinLink holds a twin's end of its port: pacing at baud or by latency, and the faults of a link.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "plant/record/archive.h"
#include "plant/twins/fault.h"

namespace firn::plant {

inline constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();

/// Holds a port's bytes in transit. TCP (byte_us = 0): bytes arrive at once, replies leave after latency_us.
/// Serial: each byte needs byte_us on the wire either way; a reply is handed over when its last byte has
/// left.
class TwinLink {
 public:
  struct Chunk {
    std::int64_t t_us = 0;
    std::string bytes;
    std::uint8_t close = 0;  ///< the instrument closes the port
    void io(Archive& a) { a.all(t_us, bytes, close); }
  };
  TwinLink(double byte_us, std::int64_t latency_us) : byte_us_(byte_us), latency_us_(latency_us) {}

  void speed_up(double factor) { byte_us_ /= factor; }
  bool connected() const { return connected_; }
  bool serial() const { return byte_us_ > 0.0; }
  bool hung() const { return hung_; }
  bool half_open() const { return half_open_; }
  void connect(std::int64_t now_us);
  void disconnect();
  void close(std::int64_t now_us);  ///< by the instrument

  /// Serial only: queues bytes with their times of arrival.
  void arrive(std::span<const std::byte> bytes, std::int64_t now_us);
  std::int64_t next_arrival_us() const { return rx_.empty() ? kNever : rx_.front().t_us; }
  std::byte pop_arrival();

  void hear(std::span<const std::byte> bytes, std::int64_t now_us);  ///< bytes of the host, for kEcho
  void reply(std::string_view bytes, std::int64_t now_us);
  std::int64_t next_send_us() const { return tx_.empty() ? kNever : tx_.front().t_us; }
  Chunk pop_send();
  bool inject(const SimFault& fault, std::int64_t now_us);  ///< false: not a fault of the link

  void io(Archive& a);

 private:
  struct Arrival {
    std::int64_t t_us = 0;
    std::byte byte{};
    std::uint8_t pad[7] = {};
  };
  struct Pending {
    FaultKind kind = FaultKind::kDropReply;
    std::uint8_t pad[7] = {};
    std::int64_t count = 0, delay_us = 0;
  };

  void send(std::string bytes, std::int64_t now_us, std::int64_t extra_us);

  double byte_us_;
  std::int64_t latency_us_;
  bool connected_ = false, hung_ = false, half_open_ = false;
  double rx_free_us_ = 0.0, tx_free_us_ = 0.0;
  std::deque<Arrival> rx_;
  std::deque<Chunk> tx_;
  std::vector<Pending> faults_;
  std::int64_t echoes_ = 0;
  std::string last_reply_;
};

}  // namespace firn::plant
