#include "drivers/heater/heater.h"

#include <cmath>
#include <utility>

namespace firn::drivers {

Heater::Heater(HeaterOptions config) : HeaterDriver(dialect_, config) {
  dialect_.allow_host_latency(config_.host_latency_s);
  identity_ =
      has_platen() ? "the platen's ON/OFF temperature controller" : "three ON/OFF temperature controllers";
}

void Heater::finish(Outcome outcome, std::int32_t code, std::string text, Effects& fx) {
  setting_ = false;
  fx.events.emplace_back(Result{outcome, -1, 0, 0, 0, code, std::move(text)});
}

void Heater::push_set_points() {
  for (int c = 0; c < thermostat::kChannels; ++c) {
    const auto n = std::size_t(c);
    const std::int32_t c100 =
        heats(n) ? std::int32_t(std::lround(set_celsius_[n] * 100.0)) : thermostat::kOff_c100;
    link_.push(thermostat::set_request({c + 1, c100}, kSet));
  }
}

void Heater::set(const std::array<double, 3>& celsius, std::int64_t now_us, Effects& fx) {
  std::string why = refusal_of(celsius);
  std::int32_t code = kLimit;
  if (busy() || phase_ != Phase::kReady) {
    why = busy() ? "the heater is busy with another command" : std::string("the heater is ") + standing();
    code = kNoCode;
  }
  if (!why.empty()) {
    fx.events.emplace_back(Result{Outcome::kRefused, -1, 0, 0, 0, code, why});
  } else {
    setting_ = commanded_ = true;
    take_set_points(celsius);
    push_set_points();
  }
  pump(now_us, fx);
}

void Heater::connected(std::int64_t, Effects& fx) {
  set_state(DeviceState::kIdentifying, identity_, fx);
  phase_ = Phase::kIdentifying;
  link_.push(thermostat::read_request(kRead));
  if (commanded_) push_set_points();
}

// The heat stays on: freezing destroys the valves [interlocks 2, 5, 7], and a platen keeps its part. A failed
// heater has been switched off already.
void Heater::stop(std::int64_t, Effects& fx) {
  if (setting_) finish(Outcome::kDone, kNoCode, "safe stop; the heat stays on", fx);
}

void Heater::lost(std::int64_t, Effects& fx) {
  if (phase_ == Phase::kDown) return;
  phase_ = Phase::kDown;
  fault(Severity::kWarning, kLinkLost, "heater: link lost; the set points stay in force", fx);
}

void Heater::failed(const Request&, std::int64_t now_us, Effects& fx) {
  reconnect(now_us, fx, "no good reply" + not_understood());
}

void Heater::tell(int channel, Effects& fx) {
  link_.push(thermostat::set_request({channel + 1, thermostat::kOff_c100}, kSet));
  HeaterFailure failure = failure_of(channel);
  fault(failure.severity, kTemperature, std::move(failure.text), fx);
}

void Heater::take(const thermostat::Reading& r, std::int64_t now_us, Effects& fx) {
  Temperatures t;
  t.celsius = r.celsius;
  t.set_celsius = set_celsius_;
  t.heating = r.heating;
  const std::array<bool, 3> news = judge(t, now_us);
  for (std::size_t c = 0; c < 3; ++c) t.fault[c] = fault_[c];
  for (int c = 0; c < 3; ++c)
    if (news[std::size_t(c)]) tell(c, fx);
  fx.measured<Heater>(t);
}

void Heater::reply(const Request& request, std::span<const std::byte> frame, std::int64_t now_us,
                   Effects& fx) {
  const std::string_view line(reinterpret_cast<const char*>(frame.data()), frame.size());
  const std::string_view text = checked_text(line, 0).value_or(std::string_view());
  if (text.starts_with("E,")) {
    fault(Severity::kWarning, kCommandRejected,
          "heater: it refuses '" + std::string(checked_text(request.text(), 0).value()) + "'", fx);
    if (request.tag == kSet && setting_) {
      link_.clear_queue();
      finish(Outcome::kFailed, kCommandRejected, "a set point was refused", fx);
    }
    return;
  }
  if (request.tag != kRead) return;
  next_read_us_ = now_us + std::int64_t(config_.poll_s * 1e6);
  if (const auto r = thermostat::parse_reading(text)) take(*r, now_us, fx);
}

bool Heater::idle(std::int64_t now_us, Effects& fx) {
  if (phase_ == Phase::kDown) return false;
  if (phase_ == Phase::kIdentifying) {
    identified();
    phase_ = Phase::kReady;
    set_state(DeviceState::kSafe, "reading", fx);
  }
  if (setting_) finish(Outcome::kDone, kNoCode, {}, fx);
  if (now_us < next_read_us_) return false;
  link_.push(thermostat::read_request(kRead));
  return true;
}

std::int64_t Heater::device_wake_us() const {
  return link_.idle() && phase_ == Phase::kReady ? next_read_us_ : 0;
}

}  // namespace firn::drivers
