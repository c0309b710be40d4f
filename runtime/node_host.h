// NodeHost runs one node step by step: write-ahead, dispatch, timers. It knows no bus and no clock, so the
// live runner, the Lab, resume and replay all drive nodes through it.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "runtime/node.h"
#include "runtime/write_ahead.h"

namespace firn {

class NodeHost {
 public:
  /// @param sink may be null (replay): nothing is written then.
  NodeHost(NodeId id, std::unique_ptr<Node> node, std::int64_t run_id, WalSink* sink);

  /// Handles one event: writes it, runs the handler, writes the outputs, returns them (valid until the next
  /// step). A message that does not decode, or breaks a limit of its type, becomes a FAULT of this node and
  /// the handler is not called. @throws the handler's exception, after the event is in the write-ahead
  /// file.
  const Outbox& step(const Event& event);

  /// Replay of a written step: runs the handler without writing. After a resume the host continues from
  /// there.
  const Outbox& replay_step(const Event& event);

  bool subscribes(std::string_view channel) const { return subscription(channel) != nullptr; }
  std::vector<std::string_view> channels() const;
  std::vector<std::string> ports() const { return node_->ports(); }
  bool writes_need_lease() const { return node_->writes_need_lease(); }
  std::string lease_refusal(Time now, std::int64_t stop_epoch) const {
    return node_->lease_refusal(now, stop_epoch);
  }

  struct Armed {
    TimerId timer;
    Time at;
  };
  /// The timer that is due first; ties by timer id.
  std::optional<Armed> next_timer() const;
  /// Whether `timer` is armed for exactly `at`: replay checks that a recorded wake-up was asked for.
  bool is_armed(TimerId timer, Time at) const;

  NodeId id() const { return id_; }
  const std::string& name() const { return name_; }
  std::uint64_t steps() const { return steps_; }
  std::int32_t incarnation() const { return incarnation_; }
  std::int64_t handler_ns() const { return handler_ns_; }  ///< summed over all steps; 0 without a stopwatch
  std::optional<int> finished() const { return finished_; }
  const std::string& finish_reason() const { return finish_reason_; }

  /// The runner lends a stopwatch (nanoseconds of any monotonic clock); without one, 0 is recorded.
  void set_stopwatch(std::int64_t (*now_ns)()) { now_ns_ = now_ns; }

 private:
  void run_handler(const Event& event);
  void apply_timers();
  void refuse(const std::string& why);

  NodeId id_;
  std::string name_;
  std::unique_ptr<Node> node_;
  struct Subscription {
    const ChannelInfo* channel = nullptr;
    std::vector<const Node::Route*> routes;
  };
  const Subscription* subscription(std::string_view channel) const;

  std::map<std::string_view, Subscription> routes_;
  std::vector<const Subscription*> by_row_;  ///< of each row of channel_table(); null: not subscribed
  Outbox outbox_;
  WalSink* sink_;
  std::map<std::uint32_t, Time> timers_;
  std::vector<std::byte> scratch_;
  std::uint64_t steps_ = 0;
  std::int32_t incarnation_ = 0;
  std::int64_t handler_ns_ = 0;
  std::optional<int> finished_;
  std::string finish_reason_;
  std::int64_t (*now_ns_)() = nullptr;
};

}  // namespace firn
