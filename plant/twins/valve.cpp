#include "plant/twins/valve.h"

#include <algorithm>
#include <cmath>

namespace firn::plant {

using namespace fvb;

namespace {

constexpr double kSilence_us = 2e6;  ///< of the host's time, without a frame while firing: closed
constexpr double kPause_us = 5e4;    ///< of the host's time, within a frame: its bytes so far are dropped
constexpr int kGuard_us = 100;

}  // namespace

ValveTwin::ValveTwin(int valve, const IceValveParams& params, double host_scale, IceWires& wires)
    : ValveBox(valve == 0 ? Port::kValveA : Port::kValveB, TwinLink(10.0e6 / params.baud, 0)),
      valve_(valve),
      params_(params),
      silence_us_(std::int64_t(kSilence_us * host_scale)),
      pause_us_(std::int64_t(kPause_us * host_scale)),
      wires_(wires) {}

void ValveTwin::take(std::span<const std::byte> bytes, std::int64_t now_us) {
  if (now_us > heard_byte_us_ + pause_us_)
    buffer_.clear();  // a UART does not report that the host's process has died
  heard_byte_us_ = now_us;
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
  std::size_t begin = 0;
  while (begin < buffer_.size()) {
    const Intake in = take_in(std::span(buffer_).subspan(begin));
    if (in.size == 0) break;
    if (in.good) execute(in, now_us);
    begin += in.size;
  }
  buffer_.erase(buffer_.begin(), buffer_.begin() + std::ptrdiff_t(begin));
}

// An answered number is answered the same way again, without action.
void ValveTwin::execute(const Intake& frame, std::int64_t now_us) {
  device_.heard_us = now_us;
  const auto boots = std::uint16_t(boot_count_);
  if (frame.kind != Kind::kHello && device_.known) {
    if (frame.number == device_.last_seq) return link_.reply(reply_, now_us);
    if (!is_newer(frame.number, device_.last_seq))
      return link_.reply(nak(frame.number, boots, Nak::kNumber), now_us);
  }
  if (frame.kind == Kind::kHello) {
    reply_ = hello(frame.number, boots, 1, device_.reset_cause);
  } else if (frame.kind == Kind::kStatus) {
    Report report{device_.state, device_.head.path, 0, 0, 0};
    if (device_.state == State::kFiring) device_.fired = wires_.nature().firing(valve_).next;
    report.fired = std::uint16_t(std::min<std::uint64_t>(device_.fired, 65535));
    if (device_.state == State::kFiring || device_.state == State::kDone) {
      report.since_trigger_us =
          std::uint32_t(std::clamp<std::int64_t>(now_us - device_.triggered_us, 0, 0xFFFFFFFF));
      report.latest_us = 12;
    }
    reply_ = status(frame.number, boots, report);
  } else {
    const Nak refusal = obey(frame, now_us);
    reply_ = refusal == Nak::kNone ? ack(frame.number, boots) : nak(frame.number, boots, refusal);
  }
  device_.last_seq = frame.number;
  device_.known = 1;
  link_.reply(reply_, now_us);
}

Nak ValveTwin::begin(const Intake& frame) {
  if (device_.state == State::kFiring || device_.state == State::kArmed) return Nak::kState;
  const auto head = head_of(frame.payload);
  if (!head || head->entries > kMaxEntries || head->pulse_us < kShortestPulse_us || head->tick_us == 0)
    return Nak::kRange;
  device_.head = *head;
  device_.fired = 0;
  device_.state = State::kLoading;
  ticks_.clear();
  ticks_.reserve(head->entries);
  return Nak::kNone;
}

Nak ValveTwin::add(const Intake& frame) {
  if (device_.state != State::kLoading) return Nak::kState;
  const auto part = part_of(frame.payload);
  if (!part) return Nak::kRange;
  if (part->offset > ticks_.size()) return Nak::kOrder;
  if (part->offset + part->ticks.size() > device_.head.entries) return Nak::kRange;
  ticks_.resize(part->offset);
  const int min_us = device_.head.pulse_us + kGuard_us;
  for (const std::uint16_t tick : part->ticks) {
    if (!ticks_.empty() &&
        (tick <= ticks_.back() || (tick - ticks_.back()) * int(device_.head.tick_us) < min_us))
      return Nak::kOrder;
    ticks_.push_back(tick);
  }
  return Nak::kNone;
}

Nak ValveTwin::obey(const Intake& frame, std::int64_t now_us) {
  switch (frame.kind) {
    case Kind::kBegin:
      return begin(frame);
    case Kind::kData:
      return add(frame);
    case Kind::kEnd: {
      if (device_.state != State::kLoading) return Nak::kState;
      if (ticks_.size() != device_.head.entries || checksum_of(frame.payload) != checksum(ticks_))
        return Nak::kMismatch;
      device_.state = State::kLoaded;
      return Nak::kNone;
    }
    case Kind::kArm: {
      if (device_.state != State::kLoaded) return Nak::kState;
      const auto wait_ms = wait_ms_of(frame.payload);
      if (!wait_ms) return Nak::kRange;
      if (never_arms_) return Nak::kNone;
      device_.state = State::kArmed;
      device_.wait_until_us = *wait_ms == 0 ? kNever : now_us + std::int64_t(*wait_ms) * 1000;
      wires_.note(now_us, port_, DeviceEvent::kValveArmed, device_.head.path);
      return Nak::kNone;
    }
    case Kind::kDisarm:
      if (device_.state == State::kFault) return Nak::kState;
      if (device_.state == State::kFiring)
        stop(now_us, FiringEnd::kDisarmed);
      else if (device_.state == State::kArmed)
        device_.state = State::kLoaded;
      device_.wait_until_us = kNever;
      return Nak::kNone;
    case Kind::kSpit: {
      if (device_.state == State::kFiring || device_.state == State::kArmed) return Nak::kState;
      const auto head = head_of(frame.payload);
      if (!head || head->entries == 0 || head->pulse_us < kShortestPulse_us ||
          head->tick_us < head->pulse_us + kGuard_us)
        return Nak::kRange;
      device_.head = *head;
      device_.fired = 0;
      ticks_.resize(head->entries);
      for (std::size_t n = 0; n < ticks_.size(); ++n) ticks_[n] = std::uint16_t(n);
      device_.state = State::kArmed;
      signal(now_us);
      return Nak::kNone;
    }
    case Kind::kAbort:
      stop(now_us, FiringEnd::kAborted);
      device_.state = State::kIdle;
      device_.wait_until_us = kNever;
      ticks_.clear();
      return Nak::kNone;
    default:
      return Nak::kRange;
  }
}

void ValveTwin::signal(std::int64_t t_us) {
  if (device_.state != State::kArmed) return;
  const double clock = 1.0 + params_.clock_ppm * 1e-6, tick_s = device_.head.tick_us * 1e-6 * clock;
  Firing list;
  list.path = device_.head.path;
  list.tick_s = tick_s;
  list.pulse_s = device_.head.pulse_us * 1e-6;
  list.ticks = ticks_;
  device_.state = State::kFiring;
  device_.triggered_us = device_.heard_us = t_us;
  device_.wait_until_us = kNever;
  const double begins_s = double(t_us) * 1e-6 + params_.trigger_delay_s;
  const double last_s = ticks_.empty() ? 0.0 : double(ticks_.back()) * tick_s;
  device_.ends_us = std::int64_t(std::ceil((begins_s + last_s + list.pulse_s) * 1e6)) + 1;
  wires_.nature().trigger_valve(valve_, begins_s, std::move(list));
}

void ValveTwin::disable(std::int64_t t_us) { stop(t_us, FiringEnd::kDisabled); }

// Closes the valve if it fires: the record holds the pulses until now.
void ValveTwin::stop(std::int64_t now_us, FiringEnd why) {
  device_.ends_us = kNever;
  if (device_.state != State::kFiring) return;
  const Firing f = wires_.nature().close_valve(valve_);
  device_.fired = f.next;
  device_.state = State::kDone;
  wires_.fired({device_.triggered_us,
                f.first_us,
                f.last_us,
                now_us,
                f.volume_mm3,
                f.path,
                std::uint32_t(f.ticks.size()),
                std::uint32_t(f.next),
                std::uint8_t(valve_),
                why,
                {}});
}

std::int64_t ValveTwin::next_device_us() const {
  std::int64_t next = std::min(device_.wait_until_us, device_.ends_us);
  if (device_.state == State::kFiring) next = std::min(next, device_.heard_us + silence_us_);
  return next;
}

void ValveTwin::device_event(std::int64_t now_us) {
  if (now_us >= device_.wait_until_us) {
    device_.wait_until_us = kNever;
    if (device_.state == State::kArmed) device_.state = State::kLoaded;
  }
  if (now_us >= device_.ends_us) return stop(now_us, FiringEnd::kThrough);
  if (device_.state == State::kFiring && now_us >= device_.heard_us + silence_us_) {
    stop(now_us, FiringEnd::kWatchdog);
    device_.state = State::kFault;
  }
}

void ValveTwin::trip(std::int64_t now_us, std::int64_t code) {
  never_arms_ = code == 5;
  if (code == 4) {
    stop(now_us, FiringEnd::kDisarmed);
    if (device_.state == State::kArmed) device_.state = State::kLoaded;
    device_.wait_until_us = kNever;
  }
  trip_line(wires_.nature(), valve_, code);
}

void ValveTwin::reboot(std::int64_t now_us) {
  stop(now_us, FiringEnd::kReboot);
  ++boot_count_;
  device_ = Device{};
  device_.reset_cause = 1;
  ticks_.clear();
  buffer_.clear();
  reply_.clear();
  wires_.note(now_us, port_, DeviceEvent::kRebooted, boot_count_);
}

void ValveTwin::io(Archive& a) {
  a.all(boot_count_, device_, ticks_, heard_byte_us_, never_arms_, buffer_, reply_, link_);
}

}  // namespace firn::plant
