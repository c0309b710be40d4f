#include "plant/twins/lamp.h"

#include "core/options/number.h"

namespace firn::plant {
namespace {

std::string framed(std::string_view text) {
  static constexpr char kHex[] = "0123456789ABCDEF";
  const std::uint8_t crc = lamp_crc8(text);
  std::string out(text);
  out += kHex[crc >> 4];
  out += kHex[crc & 15];
  out += '\r';
  return out;
}

bool integer(std::string_view text, int low, int high, int& value) {
  const std::optional<int> read = whole_number(text, low, high);
  value = read.value_or(value);
  return read.has_value();
}

}  // namespace

std::uint8_t lamp_crc8(std::string_view text) {
  std::uint8_t crc = 0;
  for (const char c : text) {
    crc = std::uint8_t(crc ^ std::uint8_t(c));
    for (int bit = 0; bit < 8; ++bit) crc = std::uint8_t(crc & 1 ? crc >> 1 ^ 0x8C : crc >> 1);
  }
  return crc;
}

LampTwin::LampTwin(const LampParams& params, Wires& wires)
    : Twin(Port::kLamp, TwinLink(10.0e6 / params.baud, 0)), params_(params), wires_(wires) {
  state_.burning = true;
}

// Bits 0 alarm, 1 burns, 2 shutter open, 3 shutter fault, 4 warm, 5 panel locked.
int LampTwin::status(std::int64_t now_us) const {
  const bool warm = state_.burning && now_us >= state_.warm_at_us;
  return (state_.alarm ? 1 : 0) | (state_.burning ? 2 : 0) | (state_.open ? 4 : 0) | (warm ? 16 : 0) |
         (state_.locked ? 32 : 0);
}

void LampTwin::take(std::span<const std::byte> bytes, std::int64_t now_us) {
  for (const std::byte b : bytes) {
    const char c = char(b);
    if (c != '\r') {
      if (line_.size() < 64) line_.push_back(c);
      continue;
    }
    std::string answer = "Err";
    if (line_.size() > 2 && framed(std::string_view(line_).substr(0, line_.size() - 2)) == line_ + '\r')
      answer = execute(std::string_view(line_).substr(0, line_.size() - 2), now_us);
    line_.clear();
    link_.reply(framed(answer), now_us);
  }
}

std::string LampTwin::execute(std::string_view command, std::int64_t now_us) {
  static const std::string kReceived = "Received", kError = "Err";
  if (command == "CONN") {
    state_.talking = true;
    return "READY";
  }
  if (!state_.talking) return kError;
  if (command == "DCON") {
    state_.talking = false;
    return "CLOSED";
  }
  if (command == "OPN") {
    if (state_.alarm) return kError;
    open(now_us, params_.max_on_us, false);
    return kReceived;
  }
  if (command == "RUN") {
    if (state_.alarm || state_.exposure_tenths == 0) return kError;
    open(now_us, std::int64_t(state_.exposure_tenths) * 100'000, true);
    return kReceived;
  }
  if (command == "CLS") {
    close(now_us, LampEvent::kClosed);
    return kReceived;
  }
  int value = 0;
  if (command.starts_with("SIL")) {
    if (!integer(command.substr(3), 1, 100, value)) return kError;
    add_dose(now_us);
    state_.iris_percent = value;
    return kReceived;
  }
  if (command.starts_with("STM")) {
    if (!integer(command.substr(3), 1, 9999, value)) return kError;
    state_.exposure_tenths = value;
    return kReceived;
  }
  if (command == "GIL") return std::to_string(state_.iris_percent);
  if (command == "GTM") return std::to_string(state_.exposure_tenths);
  if (command == "GUS") return std::to_string(status(now_us));
  if (command == "TON" || command == "TOF") {
    if (!state_.burning) state_.warm_at_us = now_us + params_.warm_up_us;
    state_.burning = command == "TON";
    if (!state_.burning) close(now_us, LampEvent::kClosed);
    return kReceived;
  }
  if (command == "GSN") return "20158";
  if (command == "VEB" || command == "VIO") return "105";
  if (command == "GLH") return "340";  // of the lamp
  if (command == "GLG" || command == "CLH") return "0";
  if (command.starts_with("SPW") || command.starts_with("SIR"))
    return kReceived;  // no power or irradiance here
  for (const char* asked : {"GPW", "GIR", "GIM", "GMP", "GPM", "SPM"})
    if (command == asked) return "0";
  if (command == "CLC") return "Done";
  if (command == "CLR") {
    state_.alarm = state_.alarm_held;
    return kReceived;
  }
  if (command == "LOC" || command == "ULOC") {
    state_.locked = command == "LOC";
    return kReceived;
  }
  return kError;
}

void LampTwin::add_dose(std::int64_t now_us) {
  if (!state_.open) return;
  if (state_.burning)
    state_.dose_s += double(now_us - state_.dose_from_us) * 1e-6 * state_.iris_percent / 100.0;
  state_.dose_from_us = now_us;
}

// A second OPN or RUN while it is open sets the time anew and never beyond the longest on-time.
void LampTwin::open(std::int64_t now_us, std::int64_t for_us, bool timed) {
  if (state_.stuck_closed) return;
  if (!state_.open) {
    state_.open = true;
    state_.opened_us = state_.dose_from_us = now_us;
    state_.dose_s = 0.0;
    wires_.lamp(now_us, LampEvent::kOpened, 0.0);
  }
  const std::int64_t last_us = state_.opened_us + params_.max_on_us;
  state_.close_at_us = std::min(now_us + for_us, last_us);
  state_.timed = timed && now_us + for_us <= last_us;
}

void LampTwin::close(std::int64_t now_us, LampEvent why) {
  if (!state_.open || state_.stuck_open) return;
  add_dose(now_us);
  state_.open = state_.timed = false;
  state_.close_at_us = kNever;
  wires_.lamp(now_us, why, state_.dose_s);
}

void LampTwin::device_event(std::int64_t now_us) {
  state_.close_at_us = kNever;
  if (state_.timed) return close(now_us, LampEvent::kClosed);
  state_.alarm = true;
  close(now_us, LampEvent::kWatchdog);
}

void LampTwin::trip(std::int64_t now_us, std::int64_t code) {
  state_.alarm_held = code == 1;
  state_.stuck_closed = code == 3;
  state_.stuck_open = code == 4;
  if (code == 2) {
    add_dose(now_us);
    state_.burning = false;
  }
  if (code != 1) return;
  state_.alarm = true;
  close(now_us, LampEvent::kClosed);
}

void LampTwin::reboot(std::int64_t now_us) {
  ++boot_count_;
  close(now_us, LampEvent::kClosed);
  state_ = State{};
  line_.clear();
  wires_.note(now_us, port_, DeviceEvent::kRebooted, boot_count_);
}

void LampTwin::io(Archive& a) { a.all(boot_count_, state_, line_, link_); }

}  // namespace firn::plant
