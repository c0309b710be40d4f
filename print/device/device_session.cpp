#include "print/device/device_session.h"

#include <poll.h>

#include <algorithm>

#include "config/experiment.h"
#include "firn/enable_t.hpp"
#include "firn/enums.h"
#include "firn/fault_t.hpp"
#include "runtime/run_clock.h"

namespace firn {
namespace {

constexpr std::int64_t kRenewEvery_us = 50'000, kLongestWait_us = 50'000;
constexpr double kSessionLease_s = 0.3, kStopWithin_s = 5.0;
constexpr std::int64_t kRun = 1;

/// The instrument's port, and behind it that of a driver class in Python that speaks through it.
std::vector<PortAddress> addresses(const NodeHost& host, const PortAddress& address) {
  if (host.ports().size() == 1) return {address};
  PortAddress program = parse_port_address("python:");
  program.driver_files = address.driver_files;
  return {address, program};
}

std::vector<PortRate> rates(NodeId id, const std::vector<PortAddress>& of) {
  std::vector<PortRate> all;
  for (const PortAddress& address : of) all.push_back(port_rate(info(id).name, address));
  return all;
}

}  // namespace

DeviceSession::DeviceSession(NodeId id, std::unique_ptr<Node> node, const PortAddress& address, Sinks sinks)
    : answering_(dynamic_cast<const AnsweringNode*>(node.get())),
      host_(id, std::move(node), kRun, nullptr),
      ports_(
          addresses(host_, address),
          [this] { return host_.lease_refusal(now(), granted_ ? std::int64_t(0) : kEpoch + 1); },
          rates(id, addresses(host_, address))),
      sinks_(std::move(sinks)),
      began_us_(monotonic_us()) {
  Event start;
  start.kind = EventKind::kStart;
  start.now = now();
  step(start);
  if (sinks_.tape)
    ports_.record([this](PortId port, Cassette::Kind kind, std::span<const std::byte> bytes) {
      if (port == PortId{0}) sinks_.tape(cassette_line(kind, double(now().us) * 1e-3, bytes));
    });
  ports_.open_all(monotonic_us());
}

DeviceSession::~DeviceSession() = default;

std::string DeviceSession::not_understood() const {
  const std::string line = answering_ ? answering_->last_not_understood() : std::string();
  return line.empty() ? line : "; the last line that was not understood: " + line;
}

Time DeviceSession::now() const { return Time{monotonic_us() - began_us_ + 1}; }

header_t DeviceSession::header() {
  header_t h{};
  h.run_id = kRun;
  h.seq = ++seq_;
  h.utime_us = now().us;
  return h;
}

void DeviceSession::deliver(std::string_view channel, std::span<const std::byte> bytes) {
  Event e;
  e.kind = EventKind::kMessage;
  e.now = now();
  e.channel = channel;
  e.bytes = bytes;
  step(e);
}

void DeviceSession::step(const Event& event) {
  const Outbox& out = host_.step(event);
  for (std::size_t n = 0; n < out.size(); ++n) {
    const Output o = out.at(n);
    if (o.kind == OutputKind::kWrite) {
      ports_.write(PortId(o.id), o.bytes, host_.writes_need_lease());
    } else if (o.kind == OutputKind::kReopen) {
      ports_.reopen(PortId(o.id), monotonic_us());
    } else if (o.kind == OutputKind::kSend) {
      const auto size = int(o.bytes.size());
      if (device_state_t state; o.channel.starts_with("STATE_") && state.decode(o.bytes.data(), 0, size) > 0)
        state_ = std::move(state);
      if (answer_t answer; o.channel.starts_with("ANSWER_") && answer.decode(o.bytes.data(), 0, size) > 0 &&
                           answer.command_id == commands_)
        answer_ = std::move(answer);
      if (fault_t fault;
          o.channel.starts_with("FAULT_") && fault.decode(o.bytes.data(), 0, size) > 0 && sinks_.note)
        sinks_.note(fault.text);
      if (sinks_.message) sinks_.message(o.channel, o.bytes);
    }
  }
}

void DeviceSession::turn() {
  if (granted_ && monotonic_us() >= lease_us_) {
    lease_us_ = monotonic_us() + kRenewEvery_us;
    enable_t lease{};
    lease.header = header();
    lease.enable_epoch = kEpoch;
    lease.enabled = 1;
    lease.lease_s = kSessionLease_s;
    std::vector<std::byte> bytes(std::size_t(lease.getEncodedSize()));
    lease.encode(bytes.data(), 0, int(bytes.size()));
    deliver(channels::kEnable.name, bytes);
  }
  while (const auto timer = host_.next_timer()) {
    Event e;
    e.now = now();
    if (timer->at > e.now) break;
    e.kind = EventKind::kWake;
    e.id = std::uint32_t(timer->timer);
    e.due = timer->at;
    step(e);
  }
  std::int64_t wait_us = kLongestWait_us;
  if (const auto timer = host_.next_timer())
    wait_us = std::clamp<std::int64_t>(timer->at.us - now().us, 0, wait_us);
  wait_us = std::clamp<std::int64_t>(ports_.due_us() - monotonic_us(), 0, wait_us);
  std::vector<pollfd> fds;
  ports_.add_to(fds);
  const timespec timeout{0, long(wait_us) * 1000};
  ::ppoll(fds.data(), fds.size(), &timeout, nullptr);
  ports_.service(
      monotonic_us(),
      [this](PortId id, LinkState link) {
        Event e;
        e.kind = EventKind::kLink;
        e.now = now();
        e.id = std::uint32_t(id);
        e.link = link;
        step(e);
      },
      [this](PortId id, std::span<const std::byte> bytes) {
        // The program of a class in Python answers before its instrument does.
        if (heard_us_ == 0 && id == PortId{0}) heard_us_ = monotonic_us();
        Event e;
        e.kind = EventKind::kIo;
        e.now = now();
        e.id = std::uint32_t(id);
        e.bytes = bytes;
        step(e);
      });
  ports_.take_refused([this](PortId id, const std::string& cause) {
    Event e;
    e.kind = EventKind::kRefused;
    e.now = now();
    e.id = std::uint32_t(id);
    e.bytes = std::as_bytes(std::span(cause));
    step(e);
  });
  for (const std::string& text : ports_.take_notices())
    if (sinks_.note) sinks_.note(text);
}

bool DeviceSession::run_until(const std::function<bool()>& done, double within_s,
                              const std::function<bool()>& interrupted) {
  const std::int64_t until = monotonic_us() + std::int64_t(within_s * 1e6);
  while (!done()) {
    if (monotonic_us() >= until || (interrupted && interrupted())) return false;
    turn();
  }
  return true;
}

void DeviceSession::command(const std::function<DeviceOrder(const OrderStamp&)>& order,
                            const std::string& text) {
  const DeviceOrder o = order({header(), ++commands_, kEpoch});
  answer_.reset();
  if (sinks_.tape) sinks_.tape(cassette_order(o.channel, double(now().us) * 1e-3, o.bytes, text));
  deliver(o.channel, o.bytes);
}

bool DeviceSession::safe() const {
  return state_ && DeviceState(state_->state) == DeviceState::kSafe && !state_->identity.empty();
}

double DeviceSession::heard_for_s() const {
  return heard_us_ == 0 ? 0.0 : double(monotonic_us() - heard_us_) * 1e-6;
}

bool DeviceSession::stop(const std::string& cause) {
  granted_ = false;
  if (!state_ || DeviceState(state_->state) == DeviceState::kDisconnected) return false;
  Event e;
  e.kind = EventKind::kLocalStop;
  e.now = now();
  e.bytes = std::as_bytes(std::span(cause));
  if (sinks_.tape) sinks_.tape(cassette_order("stop", double(now().us) * 1e-3, {}, cause));
  for (std::size_t n = 0; n < host_.ports().size(); ++n) ports_.drop_waiting(PortId(n));
  step(e);
  return run_until([this] { return safe(); }, kStopWithin_s);
}

}  // namespace firn
