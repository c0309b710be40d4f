#include "plant/twins/microdrop.h"

#include <limits>
#include <optional>

#include "core/options/number.h"

namespace firn::plant {
namespace {

constexpr int kMicrodropBaud = 19200;
constexpr std::string_view kPulseWords[] = {"PulseVoltage", "PulseLength", "PulseDelay"};
constexpr std::size_t kLongestMicrodropLine = 80;

JetParams at_its_baud(JetParams params) {
  params.baud = kMicrodropBaud;
  return params;
}

/// The last number of "Verb(1,...,n)"; none: another head, or no such call.
std::optional<int> number_at_end(std::string_view line, std::string_view verb) {
  if (!line.starts_with(verb) || !line.ends_with(')')) return std::nullopt;
  line = line.substr(verb.size(), line.size() - verb.size() - 1);
  if (!line.starts_with("(1")) return std::nullopt;
  line = line.substr(line.find_last_of("(,") + 1);
  return whole_number(line, 0, std::numeric_limits<int>::max());
}

}  // namespace

MicrodropTwin::MicrodropTwin(Port port, JetParams params, Wires& wires)
    : JetTwin(port, at_its_baud(std::move(params)), wires) {}

void MicrodropTwin::take(std::span<const std::byte> bytes, std::int64_t now_us) {
  for (const std::byte b : bytes) {
    if (char(b) != '\r') {
      if (line_.size() < kLongestMicrodropLine) line_.push_back(char(b));
      continue;
    }
    link_.reply(execute(line_, now_us) + "\r", now_us);
    line_.clear();
  }
}

std::string MicrodropTwin::execute(std::string_view line, std::int64_t now_us) {
  const auto number = [](int n) { return " " + std::to_string(n); };
  if (!params_.trigger_on.empty() && line == params_.trigger_on) {
    if (trip_ != 2) set_source(true, now_us);
    return "OK";
  }
  if (!params_.trigger_off.empty() && line == params_.trigger_off) {
    set_source(false, now_us);
    return "OK";
  }
  for (std::size_t n = 0; n < std::size(kPulseWords); ++n) {
    if (number_at_end(line, "Get" + std::string(kPulseWords[n]))) return number(words_[n]);
    if (const auto v = number_at_end(line, "Set" + std::string(kPulseWords[n]))) {
      if (state_.external) wires_.note(now_us, port_, DeviceEvent::kJetAbused, now_us - state_.last_fired_us);
      words_[n] = *v;
      return "OK";
    }
  }
  if (const auto v = number_at_end(line, "SetActive")) {
    active_ = *v == 1;
    if (!active_) set_source(false, now_us);
    return "OK";
  }
  if (number_at_end(line, "RefreshPulse")) {
    state_.waveform = words_[0] > 0 && words_[1] > 0;
    pulse_ = {double(words_[1]), 0.0, 0.0, double(words_[0])};
    return "OK";
  }
  if (const auto v = number_at_end(line, "SetFrequency"); v && *v > 0 && *v <= 65535) {
    state_.rate_hz = std::uint16_t(*v);
    return "OK";
  }
  if (const auto v = number_at_end(line, "SetDrops"); v && *v <= 65535) {
    state_.drops = std::uint16_t(*v);
    return "OK";
  }
  if (number_at_end(line, "StartGlobal")) {  // timed by the host: where the stage is by then
    if (active_ && state_.waveform) {
      state_.last_fired_us = now_us;
      ++state_.fired;
      wires_.softtrigger(now_us, port_, state_.drops);
    }
    return "OK";
  }
  if (const auto v = number_at_end(line, "SetStrobe"); v && *v <= 65535) {
    state_.strobe_delay_us = std::uint16_t(*v);
    return "OK";
  }
  if (number_at_end(line, "GetStrobe")) return number(state_.strobe_delay_us);
  if (number_at_end(line, "GetFrequency")) return number(state_.rate_hz);
  if (number_at_end(line, "GetDrops")) return number(state_.drops);
  if (number_at_end(line, "GetBusy")) return number(0);
  if (const auto what = number_at_end(line, "GetConfig")) return number(*what == 6 ? 214 : 7);
  return "?";
}

void MicrodropTwin::reboot(std::int64_t now_us) {
  JetTwin::reboot(now_us);
  line_.clear();
  active_ = false;
  words_ = {};
}

void MicrodropTwin::io(Archive& a) {
  JetTwin::io(a);
  a.all(line_, active_, words_);
}

}  // namespace firn::plant
