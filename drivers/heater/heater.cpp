#include "drivers/heater/heater.h"

#include <cmath>
#include <cstdio>

#include "core/options/enumerators.h"

namespace firn::drivers {
namespace {

constexpr std::array<const char*, 3> kNames{"(a), end effector's tip", "(b), laser window", "(c), conduit"};

bool off(double set_celsius) { return set_celsius <= kHeaterOff_degC; }

}  // namespace

const char* name(TemperatureFault fault) {
  static constexpr const char* kFaults[] = {"well",    "open thermocouple", "no rise of temperature",
                                            "too hot", "too cold",          "reading does not move"};
  static_assert(std::size(kFaults) == kTableSize<TemperatureFault>);
  return kFaults[int(fault)];
}

void HeaterWatch::reset() { *this = HeaterWatch(config_); }

TemperatureFault HeaterWatch::judge(double celsius, double set_celsius, bool heating, std::int64_t now_us) {
  if (fault_ != kHeaterWell) return fault_;
  const std::int64_t step_us = last_us_ == 0 ? 0 : now_us - last_us_;
  last_us_ = now_us;
  if (std::isnan(celsius))
    return fault_ = ++open_ >= 2 ? kOpenThermocouple : kHeaterWell;  // one may be a glitch
  open_ = 0;
  if (celsius > config_.high_degC) return fault_ = kTooHot;
  was_warm_ = was_warm_ || celsius >= config_.low_degC + 1.0;
  if (was_warm_ && celsius < config_.low_degC) return fault_ = kTooCold;

  if (!heating || off(set_celsius) || on_since_us_ == 0 || celsius >= on_from_degC_ + config_.min_rise_degC ||
      celsius >= set_celsius - 1.0) {
    on_since_us_ = heating ? now_us : 0;  // it rises, or need not: the watch begins anew
    on_from_degC_ = celsius;
  } else if (double(now_us - on_since_us_) >= config_.no_rise_s * 1e6) {
    return fault_ = kNoRise;
  }

  // A reading that stands still proves nothing while nothing heats; a heater at work moves it.
  if (same_since_us_ == 0 || celsius != same_degC_) {
    same_since_us_ = now_us;
    same_degC_ = celsius;
    worked_us_ = 0;
  } else {
    worked_us_ += heating ? step_us : 0;
    const auto frozen_us = std::int64_t(config_.frozen_s * 1e6);
    if (now_us - same_since_us_ >= frozen_us && worked_us_ >= frozen_us / 4) return fault_ = kFrozenReading;
  }
  return kHeaterWell;
}

Heater::Heater(HeaterOptions config)
    : Driver(dialect_),
      config_(config),
      watch_{HeaterWatch(config), HeaterWatch(config), HeaterWatch(config)} {
  check_options("heater", kHeaterConfig, config_);
  dialect_.allow_host_latency(config_.host_latency_s);
  identity_ =
      has_platen() ? "the platen's ON/OFF temperature controller" : "three ON/OFF temperature controllers";
  set_celsius_.fill(kHeaterOff_degC);
}

bool Heater::keeps_warm() const {
  return fault_[kTip] == kHeaterWell || (!has_platen() && fault_[kWindow] == kHeaterWell);
}

void Heater::finish(Outcome outcome, std::int32_t code, std::string text, Effects& fx) {
  setting_ = false;
  fx.events.emplace_back(Result{outcome, -1, 0, 0, 0, code, std::move(text)});
}

void Heater::push_set_points() {
  for (int c = 0; c < thermostat::kChannels; ++c) {
    const auto n = std::size_t(c);
    const bool on = !off(set_celsius_[n]) && fault_[n] == kHeaterWell;
    const std::int32_t c100 = on ? std::int32_t(std::lround(set_celsius_[n] * 100.0)) : thermostat::kOff_c100;
    link_.push(thermostat::set_request({c + 1, c100}, kSet));
  }
}

void Heater::set(const std::array<double, 3>& celsius, std::int64_t now_us, Effects& fx) {
  std::string why;
  std::int32_t code = kLimit;
  for (std::size_t c = 0; c < 3; ++c)
    if (!(celsius[c] <= config_.high_degC)) {
      char text[120];
      std::snprintf(text, sizeof text, "heater %s: a set point of %g degC is not below %g degC", kNames[c],
                    celsius[c], config_.high_degC);
      why = text;
    }
  for (std::size_t c = 0; c < 3; ++c)
    if (!watched(c) && !off(celsius[c])) why = "heater: a platen has channel 1 alone";
  if (busy() || phase_ != Phase::kReady) {
    why = busy() ? "the heater is busy with another command"
                 : std::string("the heater is ") + drivers::standing(state());
    code = kNoCode;
  }
  if (!why.empty()) {
    fx.events.emplace_back(Result{Outcome::kRefused, -1, 0, 0, 0, code, why});
  } else {
    setting_ = commanded_ = true;
    set_celsius_ = celsius;
    for (std::size_t c = 0; c < 3; ++c) {
      watch_[c].reset();
      fault_[c] = kHeaterWell;
    }
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
  const auto c = std::size_t(channel);
  const std::string what =
      std::string("heater: ") + (has_platen() ? "platen" : kNames[c]) + ": " + name(fault_[c]);
  link_.push(thermostat::set_request({channel + 1, thermostat::kOff_c100}, kSet));
  if (has_platen()) return fault(Severity::kStop, kTemperature, what + "; it is switched off", fx);
  if (!keeps_warm())
    return fault(Severity::kStop, kTemperature, what + "; neither (a) nor (b) keeps the valves from freezing",
                 fx);
  if (fault_[c] == kTooHot) return fault(Severity::kStop, kTemperature, what + "; it is switched off", fx);
  const char* then = channel == kTip      ? "; (b) alone keeps the valves from freezing"
                     : channel == kWindow ? "; (a) alone keeps the valves from freezing"
                                          : "; the fluid lines may freeze";
  fault(Severity::kWarning, kTemperature, what + then, fx);
}

void Heater::judge(const thermostat::Reading& r, std::int64_t now_us, Effects& fx) {
  Temperatures t;
  t.celsius = r.celsius;
  t.set_celsius = set_celsius_;
  t.heating = r.heating;
  std::array<bool, 3> news{};
  for (std::size_t c = 0; c < 3; ++c) {
    if (!watched(c)) continue;
    const TemperatureFault now = watch_[c].judge(r.celsius[c], set_celsius_[c], r.heating[c], now_us);
    news[c] = now != kHeaterWell && fault_[c] == kHeaterWell;
    fault_[c] = now;
    t.fault[c] = now;
  }
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
  if (const auto r = thermostat::parse_reading(text)) judge(*r, now_us, fx);
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
