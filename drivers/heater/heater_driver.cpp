#include "drivers/heater/heater_driver.h"

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

HeaterDriver::HeaterDriver(const Dialect& dialect, HeaterOptions config)
    : Driver(dialect),
      config_(config),
      watch_{HeaterWatch(config), HeaterWatch(config), HeaterWatch(config)} {
  check_options("heater", kHeaterConfig, config_);
  set_celsius_.fill(kHeaterOff_degC);
}

bool HeaterDriver::keeps_warm() const {
  return fault_[kTip] == kHeaterWell || (!has_platen() && fault_[kWindow] == kHeaterWell);
}

std::string HeaterDriver::refusal_of(const std::array<double, 3>& celsius) const {
  std::string why;
  for (std::size_t c = 0; c < 3; ++c)
    if (!(celsius[c] <= config_.high_degC)) {
      char text[120];
      std::snprintf(text, sizeof text, "heater %s: a set point of %g degC is not below %g degC", kNames[c],
                    celsius[c], config_.high_degC);
      why = text;
    }
  for (std::size_t c = 0; c < 3; ++c)
    if (!watched(c) && !off(celsius[c])) why = "heater: a platen has channel 1 alone";
  return why;
}

void HeaterDriver::take_set_points(const std::array<double, 3>& celsius) {
  set_celsius_ = celsius;
  for (std::size_t c = 0; c < 3; ++c) {
    watch_[c].reset();
    fault_[c] = kHeaterWell;
  }
}

bool HeaterDriver::heats(std::size_t channel) const {
  return !off(set_celsius_[channel]) && fault_[channel] == kHeaterWell;
}

std::array<bool, 3> HeaterDriver::judge(const Temperatures& read, std::int64_t now_us) {
  std::array<bool, 3> news{};
  for (std::size_t c = 0; c < 3; ++c) {
    if (!watched(c)) continue;
    const TemperatureFault now = watch_[c].judge(read.celsius[c], set_celsius_[c], read.heating[c], now_us);
    news[c] = now != kHeaterWell && fault_[c] == kHeaterWell;
    fault_[c] = now;
  }
  return news;
}

HeaterFailure HeaterDriver::failure_of(int channel) const {
  const auto c = std::size_t(channel);
  const std::string what =
      std::string("heater: ") + (has_platen() ? "platen" : kNames[c]) + ": " + name(fault_[c]);
  if (has_platen()) return {Severity::kStop, what + "; it is switched off"};
  if (!keeps_warm()) return {Severity::kStop, what + "; neither (a) nor (b) keeps the valves from freezing"};
  if (fault_[c] == kTooHot) return {Severity::kStop, what + "; it is switched off"};
  const char* then = channel == kTip      ? "; (b) alone keeps the valves from freezing"
                     : channel == kWindow ? "; (a) alone keeps the valves from freezing"
                                          : "; the fluid lines may freeze";
  return {Severity::kWarning, what + then};
}

}  // namespace firn::drivers
