// Link sends and receives frames over byte streams to another host, and bounds that host's clock. It never
// waits.
//
// The first stream carries all. Further ones, its lanes, carry urgent frames a second time: where packets
// get lost, one stream stands still for longer than a lease every few minutes, and two of them hardly ever at
// one time.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "runtime/relay/peer_clock.h"
#include "runtime/relay/send_queue.h"

struct pollfd;

namespace firn::relay {

class Link {
 public:
  /// Takes the descriptors over. Nothing is said before the first service().
  /// @param out_fd -1: `in_fd` is a socket for both ways
  explicit Link(int in_fd, int out_fd = -1);
  ~Link();
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;

  /// Takes over a socket for both ways. Its end is not the end of the link.
  void add_lane(int fd);

  using Take = std::function<void(const Frame&)>;
  /// Reads and hands on hello, lines, datagrams, files and bytes of ports; answers the rest itself; writes
  /// frames that may leave. Datagrams and bytes of ports that came by several lanes are handed on as often.
  /// @throws std::runtime_error: no frames come
  void service(const Take& take);
  void add_to(std::vector<pollfd>& fds) const;
  /// Waits until the last service() is kCalmNs ago: a profiler's thousand rows a second are relayed some at a
  /// time.
  void rest() const;
  /// Wall time [us] of the next service() that has something to do.
  std::int64_t due_us() const;

  void send(const Frame& frame);
  void say(std::string_view process, std::string_view line);
  /// By the first stream alone: the line comes behind the pieces of files that were sent before.
  void say_behind_files(std::string_view line);
  void set_files(SendQueue::NextFile files);
  /// Asks for the other's time from now on: kFirstAsks times quickly, then every kAskEveryNs.
  void ask_time() { asks_ = true; }
  const PeerClock& peer_clock() const { return clock_; }
  std::size_t waiting_bytes() const { return lanes_.front()->queue.waiting_bytes(); }
  bool closed() const;  ///< the first stream has ended, and all it said was taken
  /// Seconds since the last byte came.
  double silent_s() const;

  static constexpr std::int64_t kAskEveryNs = 100'000'000, kAskQuicklyNs = 10'000'000;
  static constexpr int kFirstAsks = 40;
  static constexpr std::int64_t kCalmNs = 1'500'000;

 private:
  struct Lane {
    Lane(int in_fd, int out_fd);
    ~Lane();
    int in, out;
    bool closed = false;
    FrameReader reader;
    SendQueue queue;
    std::vector<std::byte> leaving;
    std::size_t left = 0;  // bytes of `leaving` that are gone
    std::int64_t taken = 0, told_taken = 0, told_ns = 0;
  };
  void read(Lane& lane, const Take& take);
  void handle(Lane& lane, const Frame& frame, const Take& take);
  void write(Lane& lane);
  std::int64_t ask_at_ns() const {
    return asked_ns_ + (asks_made_ < kFirstAsks ? kAskQuicklyNs : kAskEveryNs);
  }

  std::vector<std::unique_ptr<Lane>> lanes_;  // the first stream, then the others
  bool asks_ = false;
  int asks_made_ = 0;
  PeerClock clock_;
  std::int64_t asked_ns_ = 0, heard_ns_, serviced_ns_ = 0;
  std::int64_t lines_sent_ = 0, lines_taken_ = 0;  // numbers of lines, which come by all lanes and count once
};

}  // namespace firn::relay
