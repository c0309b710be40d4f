// SendQueue decides which frame leaves next to another host: stops and heartbeats before messages, messages
// before files, and no more bytes on the way than the line carries at once, so that a stop never waits long.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "runtime/relay/frame.h"

namespace firn::relay {

/// Datagrams of this channel go before all others: leases, stops, faults, heartbeats, requests to resend.
bool goes_at_once(std::string_view channel);
/// Frames that wait for others, and whose bytes on the way are bounded: other datagrams, files, and the bytes
/// of ports whose instruments may send more than kMostAtOnce bytes/s.
bool goes_in_turn(const Frame& frame);
inline constexpr double kMostAtOnce = 1e6;

class SendQueue {
 public:
  /// Fills the next piece of a file, and returns false if there is none.
  using NextFile = std::function<bool(std::vector<std::byte>& frame)>;

  /// Queues a frame. A datagram takes the place of a waiting one of its channel where only the newest counts;
  /// one that waits already is not queued again; beyond kMostWaitingBytes it is dropped: the bus asks again.
  void add(const Frame& frame);
  void set_files(NextFile files) { files_ = std::move(files); }
  /// Appends frames that may leave at `now_ns`, at most about `most` bytes. Returns false if nothing may.
  bool next(std::int64_t now_ns, std::size_t most, std::vector<std::byte>& to);
  /// The other side has taken so many bytes of datagrams and files.
  void taken(std::int64_t bytes, std::int64_t now_ns);
  void set_round_trip_ns(std::int64_t ns) { round_trip_ns_ = ns; }

  std::size_t waiting_bytes() const { return at_once_bytes_ + in_turn_bytes_; }
  std::uint64_t dropped() const { return dropped_; }
  std::int64_t window_bytes() const { return window_; }
  bool has_room() const { return sent_ - acknowledged_ < window_; }

  static constexpr std::size_t kMostWaitingBytes = std::size_t(8) << 20;
  static constexpr std::int64_t kLeastWindow = 64 << 10, kFirstWindow = 128 << 10, kMostWindow = 4 << 20;

 private:
  struct Waiting {
    std::vector<std::byte> frame;
    std::string latest;      // its channel, where only the newest counts
    std::size_t digest = 0;  // of a message whose copies are not queued; 0: none
    bool counts = false;     // towards the window
  };
  void leave(Waiting& w, std::vector<std::byte>& to);

  std::deque<Waiting> at_once_, in_turn_;
  std::size_t at_once_bytes_ = 0, in_turn_bytes_ = 0;
  std::set<std::size_t> waiting_messages_;
  NextFile files_;
  std::vector<std::byte> file_frame_;
  std::uint64_t dropped_ = 0;
  // Window [bytes] = kAhead * quickest delivery of late * (round trip + kQueueNs), as BBR [Cardwell 2016].
  std::int64_t sent_ = 0, acknowledged_ = 0, window_ = kFirstWindow;
  std::int64_t round_trip_ns_ = 50'000'000;
  std::int64_t period_began_ns_ = 0, period_bytes_ = 0;
  std::deque<double> rates_;  // bytes/ns of late periods
};

}  // namespace firn::relay
