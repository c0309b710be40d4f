#include "drivers/heater/script_heater.h"

#include <limits>
#include <utility>

namespace firn::drivers {

ScriptHeater::ScriptHeater(ScriptOptions script, HeaterOptions config)
    : ScriptDriver(std::move(script), {"set", "read"}, config) {}

void ScriptHeater::set(const std::array<double, 3>& celsius, std::int64_t now_us, Effects& fx) {
  if (accepts(fx)) {
    if (std::string why = refusal_of(celsius); !why.empty()) {
      refuse(kLimit, std::move(why), fx);
    } else {
      begin_command();
      take_set_points(celsius);
      commanded_ = to_send_ = true;
    }
  }
  pump(now_us, fx);
}

bool ScriptHeater::work(std::int64_t now_us, Effects&) {
  if (std::exchange(to_send_, false)) {
    std::vector<double> points;
    for (std::size_t c = 0; c < 3; ++c)
      points.push_back(heats(c) ? set_celsius_[c] : std::numeric_limits<double>::quiet_NaN());
    call(kSet, "set", {{"*celsius", std::move(points)}}, now_us);
    return true;
  }
  if (now_us < next_read_us_) return false;
  call(kRead, "read", {}, now_us);
  return true;
}

void ScriptHeater::returned(std::uint16_t tag, const Line& line, std::int64_t now_us, Effects& fx) {
  if (tag == kSet) return finish({}, fx);
  next_read_us_ = now_us + std::int64_t(config_.poll_s * 1e6);
  take(line, now_us, fx);
}

void ScriptHeater::take(const Line& line, std::int64_t now_us, Effects& fx) {
  const auto celsius = line.values.find("celsius"), heating = line.values.find("heating");
  for (const auto& at : {celsius, heating})
    if (at == line.values.end() || at->second.size() != 3)
      return wrong("read", "it returns no three numbers \"celsius\" and \"heating\"", now_us, fx);
  Temperatures t;
  t.set_celsius = set_celsius_;
  for (std::size_t c = 0; c < 3; ++c) {
    t.celsius[c] = celsius->second[c];
    t.heating[c] = heating->second[c] != 0.0;
  }
  const std::array<bool, 3> news = judge(t, now_us);
  for (std::size_t c = 0; c < 3; ++c) t.fault[c] = fault_[c];
  for (int c = 0; c < 3; ++c)
    if (news[std::size_t(c)]) {
      HeaterFailure failure = failure_of(c);
      fault(failure.severity, kTemperature, std::move(failure.text), fx);
      to_send_ = true;  // without the channel that has failed
    }
  fx.measured<HeaterDriver>(t);
}

void ScriptHeater::became_safe(std::int64_t now_us, Effects& fx) {
  if (ending().empty() || ending() == kStopped) finish({Outcome::kDone, -1, 0, 0, 0, kNoCode, ending()}, fx);
  to_send_ = commanded_;
  next_read_us_ = now_us;
}

}  // namespace firn::drivers
