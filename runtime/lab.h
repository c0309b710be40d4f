// Lab runs all nodes and the instruments' world in one process and in simulated time: same bytes, same
// write-ahead files, thousands of times faster than the print.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/node_host.h"

namespace firn {

/// The instruments' ports, driven by simulated time. Implemented over
/// plant/world.
class LabWorld {
 public:
  /// `close`: the instrument closes the port (bytes are empty then).
  using Send =
      std::function<void(std::string_view port, std::span<const std::byte> bytes, Time at, bool close)>;
  virtual ~LabWorld() = default;
  virtual void connect(std::string_view port, Time now) = 0;
  virtual void disconnect(std::string_view port, Time now) = 0;
  virtual void receive(std::string_view port, std::span<const std::byte> bytes, Time now) = 0;
  virtual Time next_event() const = 0;                   ///< Time::never() = nothing pending
  virtual void advance(Time now, const Send& send) = 0;  ///< runs everything due up to now
};

class Lab {
 public:
  /// Sees every message when it is sent: the recorder, progress, tests.
  using Tap = std::function<void(std::string_view channel, std::span<const std::byte> bytes, Time now)>;

  explicit Lab(LabWorld* world) : world_(world) {}
  /// Nodes take part in the order in which they are added; that order breaks ties of equal time.
  void add(NodeHost* host);
  void set_tap(Tap tap) { tap_ = std::move(tap); }

  /// Delivers the start event of `incarnation` to all nodes at `now` and opens the instruments' ports.
  void start(std::int32_t incarnation, Time now);
  /// Puts a message on the bus from outside the nodes (operator, launcher).
  void publish(std::string_view channel, std::span<const std::byte> bytes);
  /// Hands a message to one node only: one that a resume finds sent but not received.
  void publish_to(NodeId node, std::string_view channel, std::span<const std::byte> bytes);

  enum class End { kFinished, kIdle, kTimeLimit };
  /// Steps until every node in `must_finish` has finished, nothing is left to do, or `limit` is reached.
  /// Same-time events are handled in the order time, node, sequence of arrival.
  End run(std::span<const NodeId> must_finish, Time limit);
  /// Handles the next event. @returns false when nothing is pending up to `limit`.
  bool step(Time limit);

  Time now() const { return now_; }
  std::uint64_t steps() const { return steps_; }

 private:
  struct Pending {
    Time at;
    int node;
    std::uint64_t seq;
    EventKind kind;
    std::uint32_t port;
    LinkState link;
    std::string_view channel;
    std::shared_ptr<const std::vector<std::byte>> bytes;
    bool operator>(const Pending& o) const {
      if (at != o.at) return at > o.at;
      if (node != o.node) return node > o.node;
      return seq > o.seq;
    }
  };
  struct PortOwner {
    std::string name;
    int node;
    std::uint32_t port;
    bool open = false;
  };

  void dispatch(int node, const Event& event);
  void carry_out(int node, const Outbox& outbox);
  void deliver(std::string_view channel, std::span<const std::byte> bytes);
  void push(Pending p);
  void run_world();

  LabWorld* world_;
  Tap tap_;
  std::vector<NodeHost*> hosts_;
  std::vector<std::optional<NodeHost::Armed>> armed_;  ///< of each host, its next timer as of its last step
  std::vector<PortOwner> ports_;
  std::vector<std::vector<int>> readers_;  ///< of each row of channel_table(), nodes in their order
  std::vector<Pending> queue_;             ///< a heap, the next event first
  Time now_;
  std::uint64_t seq_ = 0;
  std::uint64_t steps_ = 0;
};

}  // namespace firn
