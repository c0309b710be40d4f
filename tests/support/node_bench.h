// NodeBench feeds one node by hand and holds its messages; the figure of each fault must agree with its
// sentence.
#pragma once

#include <deque>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "firn/fault_t.hpp"
#include "lcmtypes/channels.h"
#include "lcmtypes/convert.h"
#include "runtime/node_host.h"
#include "tests/support/figure_words.h"

namespace firn::test {

class NodeBench {
 public:
  NodeBench(NodeId id, std::unique_ptr<Node> node) : host(id, std::move(node), kRunId, nullptr) {}
  static constexpr std::int64_t kRunId = 42;

  struct Sent {
    std::string channel;
    std::vector<std::byte> bytes;
  };

  void start(std::int32_t incarnation = 0) {
    Event e;
    e.kind = EventKind::kStart;
    e.incarnation = incarnation;
    step(e);
  }

  template <class Message>
  void give(const Channel<Message>& channel, Message m) {
    give_of(host.incarnation(), channel, std::move(m));
  }
  template <class Message>
  void give_of(std::int32_t incarnation, const Channel<Message>& channel, Message m) {
    m.header.run_id = kRunId;
    m.header.incarnation = incarnation;
    m.header.seq = ++seq_;
    m.header.utime_us = now.us;
    std::vector<std::byte> bytes(std::size_t(m.getEncodedSize()));
    m.encode(bytes.data(), 0, int(bytes.size()));
    Event e;
    e.kind = EventKind::kMessage;
    e.channel = channel.name;
    e.bytes = bytes;
    step(e);
  }

  void io(std::uint32_t port, std::span<const std::byte> bytes) {
    Event e;
    e.kind = EventKind::kIo;
    e.id = port;
    e.bytes = bytes;
    step(e);
  }

  void link(std::uint32_t port, LinkState state) {
    Event e;
    e.kind = EventKind::kLink;
    e.id = port;
    e.link = state;
    step(e);
  }

  void local_stop(const std::string& cause) {
    Event e;
    e.kind = EventKind::kLocalStop;
    e.bytes = std::as_bytes(std::span(cause));
    step(e);
  }

  /// Moves time to the first armed timer and fires it. @returns false when none is armed.
  bool wake() {
    const auto armed = host.next_timer();
    if (!armed) return false;
    now = std::max(now, armed->at);
    Event e;
    e.kind = EventKind::kWake;
    e.id = std::uint32_t(armed->timer);
    e.due = armed->at;
    step(e);
    return true;
  }

  /// Messages of a channel sent so far, oldest first.
  template <class Message>
  std::vector<Message> all(const Channel<Message>& channel) const {
    std::vector<Message> out;
    for (const Sent& s : sent)
      if (s.channel == channel.name) out.push_back(decode<Message>(s));
    return out;
  }
  template <class Message>
  Message last(const Channel<Message>& channel) const {
    const auto m = all(channel);
    if (m.empty()) throw std::runtime_error("nothing was sent on " + std::string(channel.name));
    return m.back();
  }
  template <class Message>
  static Message decode(const Sent& s) {
    Message m;
    if (m.decode(s.bytes.data(), 0, int(s.bytes.size())) < 0)
      throw std::runtime_error("sent bytes do not decode");
    return m;
  }

  NodeHost host;
  Time now;
  std::deque<Sent> sent;
  std::vector<std::byte> written;  ///< bytes for the instrument

 private:
  void step(Event e) {
    e.now = now;
    const Outbox& out = host.step(e);
    for (std::size_t n = 0; n < out.size(); ++n) {
      const Output o = out.at(n);
      if (o.kind == OutputKind::kSend)
        sent.push_back({std::string(o.channel), {o.bytes.begin(), o.bytes.end()}});
      if (o.kind == OutputKind::kSend && o.channel.starts_with("FAULT_")) {
        const fault_t fault = decode<fault_t>(sent.back());
        const std::string wrong = figure_words::figure_contradiction(fault.text, from_message(fault.figure));
        if (!wrong.empty()) throw std::runtime_error("a fault's figure: " + wrong);
      }
      if (o.kind == OutputKind::kWrite) written.insert(written.end(), o.bytes.begin(), o.bytes.end());
    }
  }
  std::int64_t seq_ = 0;
};

}  // namespace firn::test
