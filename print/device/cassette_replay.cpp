#include "print/device/cassette_replay.h"

#include <algorithm>
#include <deque>
#include <stdexcept>
#include <vector>

#include "firn/enable_t.hpp"
#include "firn/header_t.hpp"
#include "runs/migrate/run_migration.h"
#include "runtime/node_host.h"

namespace firn {
namespace {

using Kind = Cassette::Kind;

constexpr std::int64_t kLeaseEvery_us = 50'000;
constexpr std::int64_t kApart_us = 20'000;  // the host handled bytes a little after they were written down
constexpr double kLease_s = 0.3;
constexpr std::int64_t kFirstEpoch = 1;  // of a session of `firn device`

const NamedMaker& maker_named(const Product& product, const std::string& node) {
  for (const NamedMaker& m : product.nodes)
    if (info(m.id).name == node) return m;
  throw std::invalid_argument("'" + node + "' is no instrument");
}

class Player {
 public:
  Player(const NamedMaker& maker, const Cassette& cassette)
      : cassette_(cassette), host_(maker.id, maker.make(config_of(cassette), {}), 1, nullptr) {}

  std::string run() {
    if (host_.ports().size() > 1)
      throw std::invalid_argument(
          "the tape of a class in Python that speaks through Firn's port: it is played to the class by "
          "devices." +
          cassette_.node + ".port = \"cassette:FILE\"");
    Event start;
    start.kind = EventKind::kStart;
    start.now = now_;
    step(start);
    for (const Cassette::Piece& p : cassette_.pieces) {
      const Time at{std::max<std::int64_t>(now_.us, std::int64_t(p.ms * 1e3))};
      if (p.kind == Kind::kSent) {
        if (std::string difference = expect(p, at); !difference.empty()) return difference;
        continue;
      }
      advance(at);
      give(p);
    }
    // A print may end in mid talk: what the instrument's last words made the driver send is on no tape then.
    const bool cut = !cassette_.pieces.empty() && cassette_.pieces.back().kind == Kind::kReceived;
    if (!sent_.empty() && !cut) return "after the last line the driver sends" + shown(sent_.front());
    return {};
  }

 private:
  std::string expect(const Cassette::Piece& p, Time at) {
    while (leased_ && lent_us_ + kLeaseEvery_us <= at.us)
      lend(Time{std::max(now_.us, lent_us_ + kLeaseEvery_us)});
    // The host was as late as the tape says: timers fire when it had got round to them.
    while (sent_.empty()) {
      const auto timer = host_.next_timer();
      if (!timer || timer->at.us > at.us + kApart_us) break;
      wake(*timer, std::max(at, timer->at));
    }
    now_ = std::max(now_, at);
    const std::string line = "line " + std::to_string(p.line) + ": the tape has" + shown(p.bytes);
    if (sent_.empty()) return line + ", the driver sends nothing";
    const std::vector<std::byte> bytes = std::move(sent_.front());
    sent_.pop_front();
    return bytes == p.bytes ? "" : line + ", the driver sends" + shown(bytes);
  }

  void give(const Cassette::Piece& p) {
    Event e;
    e.now = now_;
    if (p.kind == Kind::kOrder) {
      e.kind = p.channel == "stop" ? EventKind::kLocalStop : EventKind::kMessage;
      e.channel = p.channel;
      e.bytes = migration_.today(p.bytes, migrated_);
      if (e.kind == EventKind::kMessage && !host_.subscribes(e.channel)) return;
      if (p.channel == "stop") leased_ = false;
      if (enable_t lease;
          p.channel == channels::kEnable.name && lease.decode(p.bytes.data(), 0, int(p.bytes.size())) > 0)
        epoch_ = lease.enable_epoch;
    } else if (p.kind == Kind::kReceived) {
      e.kind = EventKind::kIo;
      e.bytes = p.bytes;
    } else {
      e.kind = EventKind::kLink;
      e.link = p.kind == Kind::kOpened ? LinkState::kOpen : LinkState::kClosed;
    }
    step(e);
  }

  void advance(Time at) {
    while (now_ < at) {
      const auto timer = host_.next_timer();
      const std::int64_t lease_us = leased_ ? lent_us_ + kLeaseEvery_us : INT64_MAX;
      if (timer && timer->at <= at && timer->at.us <= lease_us) {
        wake(*timer, std::max(now_, timer->at));
      } else if (lease_us <= at.us) {
        lend(Time{std::max(now_.us, lease_us)});
      } else {
        now_ = at;
      }
    }
  }

  void wake(const NodeHost::Armed& timer, Time now) {
    now_ = now;
    Event e;
    e.kind = EventKind::kWake;
    e.now = now;
    e.id = std::uint32_t(timer.timer);
    e.due = timer.at;
    step(e);
  }

  // A print's lease comes every 50 ms and is not on the tape.
  void lend(Time now) {
    now_ = now;
    if (!leased_ || now.us < lent_us_ + kLeaseEvery_us) return;
    lent_us_ = now.us;
    enable_t lease{};
    lease.header.run_id = 1;
    lease.header.utime_us = now.us;
    lease.header.seq = ++seq_;
    lease.enable_epoch = epoch_;
    lease.enabled = 1;
    lease.lease_s = kLease_s;
    std::vector<std::byte> bytes(std::size_t(lease.getEncodedSize()));
    lease.encode(bytes.data(), 0, int(bytes.size()));
    Event e;
    e.kind = EventKind::kMessage;
    e.now = now;
    e.channel = channels::kEnable.name;
    e.bytes = bytes;
    step(e);
  }

  void step(const Event& event) {
    const Outbox& out = host_.step(event);
    for (std::size_t n = 0; n < out.size(); ++n)
      if (const Output o = out.at(n); o.kind == OutputKind::kWrite)
        sent_.emplace_back(o.bytes.begin(), o.bytes.end());
  }

  const Cassette& cassette_;
  const runs::RunMigration migration_;  // a tape's orders are of the version that recorded it
  std::vector<std::byte> migrated_;
  NodeHost host_;
  Time now_{1};
  std::deque<std::vector<std::byte>> sent_;
  bool leased_ = true;
  std::int64_t epoch_ = kFirstEpoch, lent_us_ = -kLeaseEvery_us, seq_ = 0;
};

}  // namespace

std::string replay_cassette(const Product& product, const Cassette& cassette) {
  for (const std::string& remark : cassette.remarks)
    if (remark.starts_with("incarnation "))
      throw std::invalid_argument("a tape of more than one incarnation of a print");
  if (config_of(cassette).empty()) throw std::invalid_argument("the tape has no experiment");
  return Player(maker_named(product, cassette.node), cassette).run();
}

}  // namespace firn
