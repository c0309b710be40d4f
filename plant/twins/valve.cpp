#include "plant/twins/valve.h"

#include <algorithm>
#include <cmath>

namespace firn::plant {

using namespace drivers::fvb;

namespace {

constexpr double kSilence_us = 2e6;  ///< of the host's time, without a frame while firing: closed
constexpr double kPause_us = 5e4;    ///< of the host's time, within a frame: its bytes so far are dropped
constexpr int kGuard_us = 100;

}  // namespace

ValveTwin::ValveTwin(int valve, const IceValveParams& params, double host_scale, IceWires& wires)
    : Twin(valve == 0 ? Port::kValveA : Port::kValveB, TwinLink(10.0e6 / params.baud, 0)),
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
    const Found frame = find(std::span(buffer_).subspan(begin));
    if (frame.kind == Found::Kind::kIncomplete) break;
    if (frame.kind == Found::Kind::kFrame) execute(frame, now_us);
    begin += frame.size;
  }
  buffer_.erase(buffer_.begin(), buffer_.begin() + std::ptrdiff_t(begin));
}

void ValveTwin::send(const std::vector<std::byte>& bytes, std::int64_t now_us) {
  link_.reply({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, now_us);
}

// An answered number is answered the same way again, without action.
void ValveTwin::execute(const Found& frame, std::int64_t now_us) {
  device_.heard_us = now_us;
  const bool hello = frame.type == Type::kHello;
  if (!hello && device_.known && frame.seq == device_.last_seq) return send(reply_, now_us);
  std::vector<std::byte> reply;
  const auto boots = std::uint16_t(boot_count_);
  if (!hello && device_.known && !newer(frame.seq, device_.last_seq)) {
    encode_nak(frame.seq, boots, Refusal::kBadSeq, reply);
    return send(reply, now_us);
  }
  if (hello) {
    encode(frame.seq, Hello{boots, 1, device_.reset_cause}, reply);
  } else if (frame.type == Type::kStatus) {
    const bool triggered = device_.state == State::kFiring || device_.state == State::kDone;
    if (device_.state == State::kFiring) device_.fired = wires_.nature().firing(valve_).next;
    encode(frame.seq,
           Status{boots, device_.state, device_.begin.path,
                  std::uint16_t(std::min<std::uint64_t>(device_.fired, 65535)),
                  triggered
                      ? std::uint32_t(std::clamp<std::int64_t>(now_us - device_.triggered_us, 0, 0xFFFFFFFF))
                      : 0,
                  std::uint16_t(triggered ? 12 : 0)},
           reply);
  } else if (const std::uint8_t refusal = obey(frame, now_us)) {
    encode_nak(frame.seq, boots, Refusal(refusal), reply);
  } else {
    encode_ack(frame.seq, boots, reply);
  }
  device_.last_seq = frame.seq;
  device_.known = 1;
  reply_ = std::move(reply);
  send(reply_, now_us);
}

std::uint8_t ValveTwin::obey(const Found& frame, std::int64_t now_us) {
  constexpr auto kState = std::uint8_t(Refusal::kWrongState), kRange = std::uint8_t(Refusal::kRange),
                 kOrder = std::uint8_t(Refusal::kOrder), kMismatch = std::uint8_t(Refusal::kMismatch);
  switch (frame.type) {
    case Type::kBegin: {
      if (device_.state == State::kFiring || device_.state == State::kArmed) return kState;
      const auto begin = parse_begin(frame.payload);
      if (!begin || begin->entries > kMostEntries || begin->pulse_us < kMinPulse_us || begin->tick_us == 0)
        return kRange;
      device_.begin = *begin;
      device_.fired = 0;
      device_.state = State::kLoading;
      ticks_.clear();
      ticks_.reserve(begin->entries);
      return 0;
    }
    case Type::kData: {
      if (device_.state != State::kLoading) return kState;
      const auto data = parse_data(frame.payload);
      if (!data) return kRange;
      if (data->offset > ticks_.size()) return kOrder;
      if (data->offset + data->entries > device_.begin.entries) return kRange;
      ticks_.resize(data->offset);
      for (std::size_t n = 0; n < data->entries; ++n) {
        const std::uint16_t tick = data->tick(n);
        const int least_us = device_.begin.pulse_us + kGuard_us;
        if (!ticks_.empty() &&
            (tick <= ticks_.back() || (tick - ticks_.back()) * int(device_.begin.tick_us) < least_us))
          return kOrder;
        ticks_.push_back(tick);
      }
      return 0;
    }
    case Type::kEnd: {
      if (device_.state != State::kLoading) return kState;
      const auto crc = parse_number(frame.payload);
      if (!crc || ticks_.size() != device_.begin.entries || list_crc(ticks_) != *crc) return kMismatch;
      device_.state = State::kLoaded;
      return 0;
    }
    case Type::kArm: {
      if (device_.state != State::kLoaded) return kState;
      const auto wait_ms = parse_number(frame.payload);
      if (!wait_ms) return kRange;
      if (never_arms_) return 0;
      device_.state = State::kArmed;
      device_.wait_until_us = *wait_ms == 0 ? kNever : now_us + std::int64_t(*wait_ms) * 1000;
      wires_.note(now_us, port_, DeviceEvent::kValveArmed, device_.begin.path);
      return 0;
    }
    case Type::kDisarm:
      if (device_.state == State::kFiring)
        stop(now_us, FiringEnd::kDisarmed);
      else if (device_.state == State::kArmed)
        device_.state = State::kLoaded;
      else if (device_.state == State::kFault)
        return kState;
      device_.wait_until_us = kNever;
      return 0;
    case Type::kAbort:
      stop(now_us, FiringEnd::kAborted);
      device_.state = State::kIdle;
      device_.wait_until_us = kNever;
      ticks_.clear();
      return 0;
    default:
      return kRange;
  }
}

void ValveTwin::signal(std::int64_t t_us) {
  if (device_.state != State::kArmed) return;
  const double clock = 1.0 + params_.clock_ppm * 1e-6, tick_s = device_.begin.tick_us * 1e-6 * clock;
  Firing list;
  list.path = device_.begin.path;
  list.tick_s = tick_s;
  list.pulse_s = device_.begin.pulse_us * 1e-6;
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
  IceNature& nature = wires_.nature();
  nature.line(valve_).block(code == 2);
  nature.break_valve(valve_, code == 3);
  if (code == 1) nature.heat().empty_tank(valve_);
  if (code == 0) nature.heat().fill_tank(valve_, 2.0e6);
  nature.refresh();
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
