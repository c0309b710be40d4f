// Net holds several transports on a simulated network in simulated wall time, with all messages sent and
// received.
#pragma once

#include <deque>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "core/grid/random.h"
#include "firn/config_t.hpp"
#include "firn/heartbeat_t.hpp"
#include "lcmtypes/channels.h"
#include "runtime/lossy.h"
#include "runtime/transport.h"

namespace firn::test {

inline constexpr std::int64_t kRun = 77;

using Bytes = std::vector<std::byte>;

/// An encoded message of any channel: fingerprint 1, header, then `size` random bytes.
inline Bytes message(std::int64_t seq, std::size_t size, RandomStream& random, std::int32_t incarnation = 0,
                     std::int64_t run = kRun) {
  Bytes out;
  const auto put = [&](auto v) {
    for (int s = int(sizeof v) * 8 - 8; s >= 0; s -= 8) out.push_back(std::byte(std::uint64_t(v) >> s));
  };
  put(std::int64_t(1));
  put(run);
  put(incarnation);
  put(seq);
  put(std::int64_t(0));
  for (std::size_t n = 0; n < size; n += 8) {
    const std::uint64_t bits = random.bits();
    for (std::size_t k = 0; k < 8 && n + k < size; ++k) out.push_back(std::byte(bits >> (8 * k)));
  }
  return out;
}

struct Peer {
  NodeId id;
  std::unique_ptr<Transport> transport;
  std::unique_ptr<Lossy> lossy;
  std::map<std::string, std::vector<Bytes>> got;
  std::map<std::string, std::vector<Bytes>> sent;
  std::int64_t beat_seq = 0;
  std::int64_t next_beat_us = 0;
};

class Net {
 public:
  Net(LossyOptions faults, TransportOptions base) : faults_(faults), base_(base) { base_.run_id = kRun; }

  Peer& add(NodeId id, const std::vector<std::string>& subscriptions) {
    peers_.push_back(std::make_unique<Peer>());
    peers_.back()->id = id;
    subscriptions_[id] = subscriptions;
    join(*peers_.back(), 0);
    return *peers_.back();
  }

  /// Kills the peer's transport and builds it again from its sent and received messages: a resume.
  void restart(Peer& p, std::int32_t incarnation) {
    injected_ += p.lossy->counts().injected();
    base_.incarnation = incarnation;
    join(p, incarnation);
    for (const auto& [channel, list] : p.sent)
      for (const Bytes& m : list) p.transport->restore_sent(channel, m);
    for (const auto& [channel, list] : p.got)
      for (const Bytes& m : list) p.transport->restore_received(channel, m);
  }

  void send(Peer& p, const std::string& channel, Bytes m) {
    p.transport->send(channel, m, now_us);
    p.sent[channel].push_back(std::move(m));
  }

  /// Moves simulated time on by steps of 100 us.
  void run(std::int64_t for_us) {
    for (const std::int64_t end = now_us + for_us; now_us < end; now_us += 100) {
      for (auto& p : peers_) {
        if (now_us >= p->next_beat_us) beat(*p);
        p->transport->tick(now_us);
        Transport::Datagram d;
        while (p->transport->next_datagram(now_us, d)) {
          ++datagrams;
          largest = std::max(largest, d.bytes.size() + d.channel.size() + 1);
          for (auto& to : peers_)
            if (to != p && listens(*to, d.channel)) to->lossy->receive(d.channel, d.bytes, now_us, sink(*to));
        }
      }
      for (auto& p : peers_) p->lossy->release(now_us, sink(*p));
    }
  }

  bool idle() const {
    for (const auto& p : peers_)
      if (p->transport->waiting() || p->transport->backlog_bytes() > 0) return false;
    return true;
  }
  std::uint64_t injected() const {
    std::uint64_t n = injected_;
    for (const auto& p : peers_) n += p->lossy->counts().injected();
    return n;
  }

  std::int64_t now_us = 0;
  std::uint64_t datagrams = 0;
  std::size_t largest = 0;

 private:
  void join(Peer& p, std::int32_t incarnation) {
    TransportOptions o = base_;
    o.self = p.id;
    o.incarnation = incarnation;
    Peer* peer = &p;
    p.transport = std::make_unique<Transport>(
        o,
        [peer](const ChannelInfo& row, std::span<const std::byte> bytes) {
          peer->got[std::string(row.name)].emplace_back(bytes.begin(), bytes.end());
        },
        [peer](std::string_view channel, std::int64_t seq, Bytes& to) {
          const auto& list = peer->sent[std::string(channel)];
          if (seq < 1 || std::size_t(seq) > list.size()) return false;
          to = list[std::size_t(seq - 1)];
          return true;
        });
    LossyOptions f = faults_;
    f.node = std::uint32_t(p.id);
    f.incarnation = std::uint32_t(incarnation);
    p.lossy = std::make_unique<Lossy>(f);
    for (const std::string& s : subscriptions_[p.id]) p.transport->subscribe(s);
    const auto wire = p.transport->wire_channels();
    listens_[p.id] = {wire.begin(), wire.end()};
    incarnation_[p.id] = incarnation;
  }
  bool listens(const Peer& p, std::string_view channel) const {
    return listens_.at(p.id).count(std::string(channel)) != 0;
  }
  Lossy::Sink sink(Peer& p) {
    return [this, &p](std::string_view channel, std::span<const std::byte> b) {
      p.transport->receive(channel, b, now_us);
    };
  }
  void beat(Peer& p) {
    p.next_beat_us = now_us + 100'000;
    heartbeat_t m{};
    m.header.run_id = kRun;
    m.header.incarnation = incarnation_[p.id];
    m.header.seq = ++p.beat_seq;
    m.node = info(p.id).name;
    for (const Transport::Last& l : p.transport->last_sent()) {
      m.channel.emplace_back(l.channel);
      m.last_seq.push_back(l.seq);
    }
    m.n = std::int32_t(m.channel.size());
    Bytes bytes(std::size_t(m.getEncodedSize()));
    m.encode(bytes.data(), 0, int(bytes.size()));
    p.transport->send(channels::heartbeat(p.id).name, bytes, now_us);
  }

  LossyOptions faults_;
  TransportOptions base_;
  std::uint64_t injected_ = 0;
  std::deque<std::unique_ptr<Peer>> peers_;
  std::map<NodeId, std::vector<std::string>> subscriptions_;
  std::map<NodeId, std::set<std::string>> listens_;
  std::map<NodeId, std::int32_t> incarnation_;
};

}  // namespace firn::test
