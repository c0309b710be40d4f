#include "plant/twins/jet.h"

#include <cmath>
#include <string>

namespace firn::plant {
namespace {

constexpr std::uint8_t kAck = 0x06, kNak = 0x15;
enum Command : std::uint8_t {
  kReset = 0x01,
  kPoll = 0x02,
  kDrops = 0x03,
  kContMode = 0x04,
  kPulse = 0x06,
  kStrobeDiv = 0x07,
  kSource = 0x08,
  kSoftTrigger = 0x09,
  kStrobeEnable = 0x10,
  kLowFreq = 0x11,
  kFullFreq = 0x12,
  kStrobeDelay = 0x13,
  kDump = 0x60,
  kGetVersion = 0xF0,
};
enum Status : std::uint8_t {
  kOk = 0,
  kBadSum = 1,
  kJetUnknown = 2,
  kBadLength = 3,
  kBusy = 4,
  kBadValue = 5
};

int data_length(std::uint8_t command) {
  switch (command) {
    case kReset:
    case kPoll:
    case kSoftTrigger:
    case kDump:
    case kGetVersion:
      return 0;
    case kContMode:
    case kStrobeDiv:
    case kSource:
    case kStrobeEnable:
      return 1;
    case kDrops:
    case kLowFreq:
    case kFullFreq:
      return 2;
    case kStrobeDelay:
      return 3;
    case kPulse:
      return 19;
    default:
      return -1;
  }
}

}  // namespace

JetTwin::JetTwin(Port port, const JetParams& params, Wires& wires)
    : Twin(port, TwinLink(10.0e6 / params.baud, 0)), params_(params), wires_(wires) {}

void JetTwin::take(std::span<const std::byte> bytes, std::int64_t now_us) {
  for (const std::byte b : bytes)
    if (now_us >= deaf_until_us_) byte(std::uint8_t(b), now_us);
}

void JetTwin::byte(std::uint8_t b, std::int64_t now_us) {
  if (frame_.empty()) {
    static constexpr std::string_view kGreeting = "X2000";
    if (b == 'S' && remote_) {
      frame_.push_back(b);
    } else if (b == 'Q') {
      greeting_ = 0;
      link_.reply(">", now_us);
    } else if (b == std::uint8_t(kGreeting[greeting_])) {
      const char echo = char(b);
      if (++greeting_ == kGreeting.size()) {
        remote_ = true;
        greeting_ = 0;
      }
      link_.reply({&echo, 1}, now_us);
    } else {
      greeting_ = 0;
    }
    return;
  }
  frame_.push_back(b);
  const std::size_t length = frame_[1];
  if (length < 2 || length > 32) {
    answer(false, frame_.size() > 2 ? frame_[2] : 0, kBadLength, now_us);
    frame_.clear();
  } else if (frame_.size() == length + 2) {
    execute(now_us);
    frame_.clear();
  }
}

// Idle, dwell and echo level.
bool JetTwin::beyond_head(const std::uint8_t* pulse) const {
  for (const int at : {7, 9, 11}) {
    const auto level_v = std::int16_t(std::uint16_t(pulse[at] << 8 | pulse[at + 1]));
    if (params_.max_v > 0.0 && std::abs(double(level_v)) > params_.max_v) return true;
  }
  return false;
}

void JetTwin::answer(bool ack, std::uint8_t command, std::uint8_t status, std::int64_t now_us) {
  const char bytes[4] = {char(ack ? kAck : kNak), char(command), char(status), char(command + status)};
  link_.reply({bytes, 4}, now_us);
}

void JetTwin::execute(std::int64_t now_us) {
  const std::uint8_t command = frame_[2];
  const std::uint8_t* data = frame_.data() + 3;
  // len counts itself, the command and the data.
  const int count = int(frame_[1]) - 2, wanted = data_length(command);
  std::uint8_t sum = 0;
  for (std::size_t n = 1; n + 1 < frame_.size(); ++n) sum = std::uint8_t(sum + frame_[n]);
  if (sum != frame_.back()) return answer(false, command, kBadSum, now_us);
  if (wanted < 0) return answer(false, command, kJetUnknown, now_us);
  if (count != wanted) return answer(false, command, kBadLength, now_us);
  if (now_us < state_.busy_until_us) return answer(false, command, kBusy, now_us);
  const auto u16 = [&](int at) { return std::uint16_t(data[at] << 8 | data[at + 1]); };
  switch (command) {
    case kReset:
      set_source(false, now_us);
      state_ = State{};
      state_.busy_until_us = now_us + params_.reset_us;
      return answer(true, command, kOk, state_.busy_until_us);  // when it is through
    case kPoll:
      return answer(true, command,
                    std::uint8_t((state_.jetting ? 1 : 0) | (state_.continuous ? 2 : 0) |
                                 (state_.external ? 4 : 0) | (state_.strobe ? 8 : 0)),
                    now_us);
    case kDrops:
      state_.drops = u16(0);
      break;
    case kContMode:
      state_.continuous = data[0] != 0;
      state_.jetting = state_.jetting && state_.continuous;
      break;
    case kPulse:
      // Their comment: changing the waveform while jetting "can break the JetDrive".
      if (state_.external || state_.continuous || beyond_head(data))
        wires_.note(now_us, port_, DeviceEvent::kJetAbused, now_us - state_.last_fired_us);
      state_.waveform = true;
      pulse_ = {u16(2) / 10.0, u16(13) / 10.0, u16(15) / 10.0,
                double(std::int16_t(u16(9)) - std::int16_t(u16(7)))};
      state_.busy_until_us = now_us + params_.pulse_us;
      return answer(true, command, kOk, state_.busy_until_us);
    case kStrobeDiv:
      state_.strobe_divider = data[0];
      break;
    case kSource:
      if (trip_ != 2 || data[0] == 0) set_source(data[0] != 0, now_us);
      break;
    case kSoftTrigger:
      if (!state_.waveform) return answer(false, command, kBadValue, now_us);
      state_.last_fired_us = now_us;
      ++state_.fired;
      state_.starts += state_.continuous && !state_.jetting;
      state_.jetting = state_.continuous;
      wires_.softtrigger(now_us, port_, state_.drops);
      break;
    case kStrobeEnable:
      state_.strobe = data[0];
      break;
    case kLowFreq:
      state_.low_rate_hz = u16(0);
      break;
    case kFullFreq:
      if (u16(0) == 0) return answer(false, command, kBadValue, now_us);
      state_.rate_hz = u16(0);
      break;
    case kStrobeDelay:
      state_.strobe_delay_us = u16(1);
      break;
    case kDump:
      return dump(now_us);
    case kGetVersion: {
      // Version 128: POLL tells the source.
      const char bytes[5] = {char(kAck), char(command), 3, char(128), char(command + 131)};
      return link_.reply({bytes, 5}, now_us);
    }
    default:
      return answer(false, command, kJetUnknown, now_us);
  }
  answer(true, command, kOk, now_us);
}

void JetTwin::set_source(bool external, std::int64_t now_us) {
  if (external) {
    state_.fired = 0;
    wires_.note(now_us, port_, DeviceEvent::kJetArmed, 0);
  } else if (state_.external) {
    wires_.note(now_us, port_, DeviceEvent::kJetDisarmed, state_.fired);
  }
  state_.external = external;
}

void JetTwin::dump(std::int64_t now_us) {
  std::string bytes{char(kAck), char(kDump)};
  const auto big = [&](std::uint32_t value, int count) {
    for (int n = count - 1; n >= 0; --n) bytes.push_back(char(value >> 8 * n));
  };
  big(state_.fired, 4);
  big(boot_count_, 4);
  big(state_.external, 1);
  big(state_.waveform, 1);
  big(state_.drops, 2);
  big(state_.rate_hz, 2);
  big(state_.continuous, 1);
  bytes.resize(28, '\0');
  std::uint8_t sum = 0;
  for (std::size_t n = 1; n < bytes.size(); ++n) sum = std::uint8_t(sum + std::uint8_t(bytes[n]));
  bytes.push_back(char(sum));
  link_.reply(bytes, now_us);
}

ShotOutcome JetTwin::trigger(std::int64_t t_us, int& droplets) {
  if (!state_.external) return ShotOutcome::kGatedSource;
  if (t_us < state_.busy_until_us) return ShotOutcome::kGatedBusy;
  if (!state_.waveform) return ShotOutcome::kGatedNoWaveform;
  // One microsecond of grace: crossing times are rounded to it.
  if (double(t_us - state_.last_fired_us + 1) * params_.max_rate_hz < 1e6) return ShotOutcome::kGatedTooFast;
  state_.last_fired_us = t_us;
  ++state_.fired;
  droplets = state_.drops;
  return ShotOutcome::kFired;
}

void JetTwin::reboot(std::int64_t now_us) {
  ++boot_count_;
  set_source(false, now_us);
  state_ = State{};
  remote_ = false;
  greeting_ = 0;
  frame_.clear();
  wires_.note(now_us, port_, DeviceEvent::kRebooted, boot_count_);
}

void JetTwin::trip(std::int64_t now_us, std::int64_t code) {
  trip_ = code;
  if (code == 1) set_source(false, now_us);
}

void JetTwin::io(Archive& a) {
  a.all(boot_count_, state_, pulse_, trip_, deaf_until_us_, remote_, greeting_, frame_, link_);
}

}  // namespace firn::plant
