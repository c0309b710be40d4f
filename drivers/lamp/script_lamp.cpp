#include "drivers/lamp/script_lamp.h"

#include <cmath>
#include <utility>

namespace firn::drivers {
namespace {

constexpr std::int64_t kScriptOverdueGrace_us = 500'000;

}  // namespace

ScriptLamp::ScriptLamp(ScriptOptions script, LampOptions config)
    : ScriptDriver(std::move(script), {"on", "off"}), config_(std::move(config)) {
  check_options("lamp", kLampConfig, config_);
}

void ScriptLamp::begin_exposure(double exposure_s, int iris_percent, std::int64_t now_us, Effects& fx) {
  if (!accepts(fx)) return;
  if (!barred_.empty()) return refuse(kLampOn, barred_, fx);
  if (std::string why = exposure_refusal(exposure_s, iris_percent, config_); !why.empty())
    return refuse(kLimit, std::move(why), fx);
  begin_command();
  acts();  // from here on nobody knows until off() has returned
  exposure_us_ = std::llround(exposure_s * 1e6);
  overdue_us_ = now_us + std::int64_t(config_.max_on_s * 1e6) + kScriptOverdueGrace_us;
  set_state(DeviceState::kActive, "exposing", fx);
  call(kOn, "on", iris_percent == kKeepIris ? Values{} : Values{{"iris_percent", {double(iris_percent)}}},
       now_us);
}

void ScriptLamp::fail(const std::string& why, std::int64_t now_us, Effects& fx) {
  fault(Severity::kStop, kLampOn, "lamp: " + why, fx);
  ends_us_ = 0;
  make_safe(why, kLampOn, now_us, fx);
}

void ScriptLamp::returned(std::uint16_t tag, const Line& line, std::int64_t now_us, Effects& fx) {
  switch (tag) {
    case kOn:
      ends_us_ = now_us + exposure_us_;
      if (has("lit")) call(kLit, "lit", {}, now_us);
      return;
    case kLit:
      if (line.number("value") == 0.0) fail("it was switched on, and does not shine", now_us, fx);
      return;
    case kOff:
      if (has("lit")) return call(kDark, "lit", {}, now_us);
      return exposed(fx);
    case kDark:
      if (line.number("value") != 0.0) return fail("it was switched off, and shines", now_us, fx);
      return exposed(fx);
    default:
      return;
  }
}

void ScriptLamp::exposed(Effects& fx) {
  end_acting();
  overdue_us_ = 0;
  set_state(DeviceState::kSafe, "the exposure is over", fx);
  finish({}, fx);
}

void ScriptLamp::became_safe(std::int64_t, Effects&) { ends_us_ = overdue_us_ = 0; }

bool ScriptLamp::work(std::int64_t now_us, Effects&) {
  if (ends_us_ == 0 || now_us < ends_us_) return false;
  ends_us_ = 0;
  call(kOff, "off", {}, now_us);
  return true;
}

void ScriptLamp::work_tick(std::int64_t now_us, Effects& fx) {
  if (overdue_us_ == 0 || now_us < overdue_us_) return;
  overdue_us_ = 0;
  char why[100];
  std::snprintf(why, sizeof why, "it shines for longer than lamp.max_on_s = %g s", config_.max_on_s);
  fail(why, now_us, fx);
}

void ScriptLamp::bar(std::string_view why, std::int64_t now_us, Effects& fx) {
  barred_ = why;
  if (!barred_.empty() && busy() && !stopping()) fail(barred_, now_us, fx);
  pump(now_us, fx);
}

void ScriptLamp::release(std::int64_t now_us, Effects& fx) {
  if (ready()) make_safe({}, kNoCode, now_us, fx);
  pump(now_us, fx);
}

void ScriptLamp::service(std::string_view verb, std::span<const double> v, std::int64_t now_us, Effects& fx) {
  if (verb == "shutter" && v.size() == 1) return begin_exposure(v[0], kKeepIris, now_us, fx);
  LampDriver::service(verb, v, now_us, fx);
}

}  // namespace firn::drivers
