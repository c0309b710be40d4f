#include "runtime/ports.h"

#include <poll.h>

#include <algorithm>
#include <utility>

namespace firn {
namespace {

constexpr std::int64_t kRetry_us = 50'000;  // of the simulated world's sockets
constexpr std::int64_t kShortestPause_us = 100'000, kLongestPause_us = 5'000'000;
constexpr std::size_t kMaxWaiting = std::size_t(4)
                                    << 20;  // an instrument that reads nothing is not worth more

}  // namespace

Ports::Ports(const std::vector<PortAddress>& addresses, LeaseRefusal lease_refusal,
             const std::vector<PortRate>& rates)
    : lease_refusal_(std::move(lease_refusal)) {
  for (const PortAddress& address : addresses) ports_.emplace_back(address);
  for (std::size_t n = 0; n < std::min(rates.size(), ports_.size()); ++n)
    ports_[n].meter = RateMeter(rates[n]);
}

void Ports::open_all(std::int64_t wall_us) {
  for (Port& p : ports_) p.connect_at_us = wall_us;
}

void Ports::drop_waiting(PortId port) {
  Port& p = ports_.at(std::size_t(port));
  if (std::exchange(p.stopped, true)) return;
  for (const Waiting& w : p.waiting)
    if (w.of_command) p.refused = "a stop overtook it";
  p.waiting.clear();
  p.waiting_bytes = 0;
  p.wire.drop_unsent();
}

void Ports::write(PortId port, std::span<const std::byte> bytes, bool of_command) {
  Port& p = ports_.at(std::size_t(port));
  if (!p.told_open) return;  // the driver was told that the link is closed
  if (p.waiting_bytes + bytes.size() > kMaxWaiting) return lost(p);
  if (of_command) p.stopped = false;
  p.waiting.push_back({{bytes.begin(), bytes.end()}, 0, of_command});
  p.waiting_bytes += bytes.size();
  flush(p);
}

void Ports::reopen(PortId port, std::int64_t wall_us) {
  Port& p = ports_.at(std::size_t(port));
  // A driver asks again before a line has woken up or a host has answered: that attempt goes on.
  if (!p.told_open && wall_us != INT64_MAX && p.wire.state() == PortWire::State::kConnecting) return;
  if (p.told_open)
    lost(p);
  else
    close(p);
  p.connect_at_us = wall_us;
}

void Ports::add_to(std::vector<pollfd>& fds) const {
  for (const Port& p : ports_) {
    const bool connecting = p.wire.state() == PortWire::State::kConnecting;
    if (p.wire.fd() >= 0 && !(connecting && p.wire.address().kind == PortAddress::Kind::kSerial))
      fds.push_back({p.wire.fd(),
                     short(connecting          ? POLLOUT
                           : p.waiting.empty() ? POLLIN
                                               : POLLIN | POLLOUT),
                     0});
  }
}

void Ports::connect(Port& p, std::int64_t wall_us) {
  if (p.wire.state() == PortWire::State::kClosed) {
    if (wall_us < p.connect_at_us) return;
    p.connect_at_us = INT64_MAX;
    p.wire.open(wall_us);
  }
  if (p.wire.settle(wall_us) != PortWire::State::kClosed) return;
  const bool near = p.wire.address().kind == PortAddress::Kind::kUnix;
  p.pause_us = near ? kRetry_us : std::clamp(2 * p.pause_us, kShortestPause_us, kLongestPause_us);
  p.connect_at_us = wall_us + p.pause_us;
  if (!near && p.said != p.wire.trouble()) notices_.push_back((p.said = p.wire.trouble()) + "; trying again");
}

void Ports::service(std::int64_t wall_us, const OnLink& on_link, const OnBytes& on_bytes) {
  for (std::size_t n = 0; n < ports_.size(); ++n) {
    Port& p = ports_[n];
    const PortId id = PortId(n);
    const auto tell_closed = [&] {
      if (std::exchange(p.tell_closed, false)) on_link(id, LinkState::kClosed);
    };
    tell_closed();
    connect(p, wall_us);
    if (p.wire.state() != PortWire::State::kOpen) continue;
    if (!std::exchange(p.told_open, true)) {
      p.pause_us = 0;
      p.said.clear();
      tell(p, Cassette::Kind::kOpened);
      on_link(id, LinkState::kOpen);
    }
    flush(p);
    if (p.told_open) read(p, wall_us, on_bytes);
    tell_closed();
  }
}

void Ports::read(Port& p, std::int64_t wall_us, const OnBytes& on_bytes) {
  std::byte buffer[kReadPerTurn];
  std::size_t count = 0;
  const PortWire::Io io = p.wire.read(buffer, count);
  if (io == PortWire::Io::kLost) lost(p);
  if (io != PortWire::Io::kDone) return;
  if (const std::string excess = p.meter.take(count, wall_us); !excess.empty()) {
    notices_.push_back(to_text(p.wire.address()) + ": " + excess + ": the link is closed");
    return lost(p);
  }
  tell(p, Cassette::Kind::kReceived, std::span(buffer, count));
  on_bytes(PortId(&p - ports_.data()), std::span(buffer, count));
}

std::vector<std::string> Ports::take_notices() { return std::exchange(notices_, {}); }

std::string Ports::trouble() const {
  const auto broken =
      std::ranges::find_if(ports_, [](const Port& p) { return !p.told_open && !p.said.empty(); });
  return broken == ports_.end() ? "" : broken->said;
}

void Ports::take_refused(const OnRefused& on_refused) {
  for (std::size_t n = 0; n < ports_.size(); ++n)
    if (const std::string cause = std::exchange(ports_[n].refused, {}); !cause.empty())
      on_refused(PortId(n), cause);
}

std::int64_t Ports::due_us() const {
  std::int64_t due = INT64_MAX;
  for (const Port& p : ports_) due = std::min({due, p.tell_closed ? 0 : p.connect_at_us, p.wire.due_us()});
  return due;
}

void Ports::close(Port& p) {
  p.wire.close();
  p.told_open = p.stopped = false;
  p.waiting.clear();
  p.waiting_bytes = 0;
}

void Ports::lost(Port& p) {
  if (p.told_open) tell(p, Cassette::Kind::kClosed);
  const bool near = p.wire.address().kind == PortAddress::Kind::kUnix;
  if (!near && !p.wire.trouble().empty() && p.said != p.wire.trouble())
    notices_.push_back(p.said = p.wire.trouble());
  close(p);
  p.tell_closed = true;
}

void Ports::flush(Port& p) {
  while (p.told_open && !p.waiting.empty()) {
    Waiting& w = p.waiting.front();
    if (std::string refusal = w.of_command && lease_refusal_ ? lease_refusal_() : ""; !refusal.empty()) {
      p.refused = std::move(refusal);
      if (w.sent > 0) return lost(p);
      p.waiting_bytes -= w.bytes.size();
      p.waiting.pop_front();
      continue;
    }
    std::size_t sent = 0;
    const PortWire::Io io = p.wire.write(std::span(w.bytes).subspan(w.sent), sent);
    if (io == PortWire::Io::kLater) return;
    if (io == PortWire::Io::kLost) return lost(p);
    w.sent += sent;
    if (w.sent == w.bytes.size()) {
      tell(p, Cassette::Kind::kSent, w.bytes);
      if (!p.wire.trouble().empty() && p.said != p.wire.trouble())
        notices_.push_back(p.said = p.wire.trouble());
      p.waiting_bytes -= w.bytes.size();
      p.waiting.pop_front();
    }
  }
}

}  // namespace firn
