// CommandedLab runs instruments of a lab under one operator's commands: their nodes, that of safety and their
// drivers, one act after the other, on real ports or on the byte-level twins.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "config/experiment.h"
#include "firn/answer_t.hpp"
#include "firn/device_state_t.hpp"
#include "firn/enums.h"
#include "runtime/lab.h"
#include "runtime/node_host.h"

namespace firn {

class PlantWorld;
class SimulatedInstruments;

class CommandedLab {
 public:
  using Nodes = std::span<const std::pair<NodeId, MakeNode>>;

  /// Without a port outside the simulation the lab runs in simulated time, else by the clock.
  CommandedLab(const Experiment& experiment, Nodes nodes, const Blobs& inputs);
  virtual ~CommandedLab();

  // All acts throw std::runtime_error with the message of the instrument or of safety when one fails.

  /// Waits until all instruments are safe and the lease is granted.
  void get_safe(double seconds);
  /// @throws std::runtime_error: `done` has not become true within `seconds` of lab time
  template <class Done>
  void until(Done&& done, double seconds, const std::string& what) {
    const Time limit = lab_.now().after_s(seconds);
    while (!done())
      if (!step(limit, what)) fail_late(what, seconds);
  }
  void wait(double seconds);

  template <class Message>
  void send(NodeId from, const Channel<Message>& channel, Message message) {
    Outbox& out = outbox(from);
    out.begin(lab_.now(), 0);
    out.send(channel, std::move(message));
    for (std::size_t n = 0; n < out.size(); ++n) lab_.publish(out.at(n).channel, out.at(n).bytes);
  }

  /// Commands and waits for the answer. A refusal is tried again: the lease may have reached
  /// us before the driver.
  template <class Command>
  answer_t command(const Channel<Command>& channel, Command c, double seconds, const std::string& what,
                   NodeId from = NodeId::kScheduler) {
    for (int attempt = 0; attempt < 5; ++attempt) {
      c.command_id = ++command_id_;
      c.enable_epoch = epoch_;
      answer_.reset();
      send(from, channel, c);
      until([&] { return answer_.has_value(); }, seconds, what);
      if (Outcome(answer_->outcome) != Outcome::kRefused) break;
      wait(0.1);
    }
    if (const Outcome o = Outcome(answer_->outcome); o != Outcome::kDone && o != Outcome::kReady)
      throw std::runtime_error(what + ": " + answer_->node + ": " + answer_->text);
    return *answer_;
  }

  double now_s() const { return lab_.now().s(); }
  const PlantWorld* simulated() const;   ///< nullptr: on ports outside the simulation
  SimulatedInstruments* beside() const;  ///< beside real ones; nullptr: all are simulated, or none

 protected:
  /// A message of the lab's nodes.
  virtual void heard(std::string_view, std::span<const std::byte>) {}

  template <class Message>
  static std::optional<Message> decoded(std::span<const std::byte> bytes) {
    Message m;
    if (m.decode(bytes.data(), 0, int(bytes.size())) < 0) return std::nullopt;
    return m;
  }

 private:
  struct Instruments;

  void hear(std::string_view channel, std::span<const std::byte> bytes);
  bool step(Time limit, const std::string& what);
  [[noreturn]] void fail_late(const std::string& what, double seconds);
  Outbox& outbox(NodeId node);

  std::unique_ptr<Instruments> instruments_;
  Lab lab_;
  std::map<NodeId, Outbox> outboxes_;
  std::vector<std::unique_ptr<NodeHost>> hosts_;
  std::vector<NodeId> drivers_;
  std::map<NodeId, DeviceState> states_;
  std::int64_t epoch_ = 0, command_id_ = 0;
  bool enabled_ = false;
  std::optional<answer_t> answer_;
  std::string stopped_;
};

}  // namespace firn
