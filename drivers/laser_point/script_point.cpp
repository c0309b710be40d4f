#include "drivers/laser_point/script_point.h"

#include <string>
#include <utility>
#include <vector>

namespace firn::drivers {

ScriptPoint::ScriptPoint(ScriptOptions script, LaserPointOptions config)
    : ScriptDriver(std::move(script), {"reading"}), config_(std::move(config)) {
  check_options("laser_point", kLaserPointConfig, config_);
}

// A class that only reads serves calibrations and firn device; a series needs both methods.
bool ScriptPoint::lacks(const char* method, Effects& fx) {
  if (has(method)) return false;
  refuse(kInstrument, script().class_name + " has no method " + method + "(): it takes no series", fx);
  return true;
}

void ScriptPoint::arm(int material, int samples, double period_s, std::int64_t now_us, Effects& fx) {
  if (accepts(fx) && !lacks("arm", fx) && !lacks("collect", fx)) {
    if (material < 0 || material > 1) {
      refuse(kLimit, "material " + std::to_string(material) + " is neither 0 nor 1", fx);
    } else if (samples < 1 || samples > config_.dialect.most_stored) {
      refuse(kLimit,
             std::to_string(samples) + " samples are outside [1, " +
                 std::to_string(config_.dialect.most_stored) + "]",
             fx);
    } else if (!(period_s > 0.0 && period_s <= 10.0)) {
      refuse(kLimit, "a period of " + std::to_string(period_s) + " s is outside (0, 10] s", fx);
    } else {
      begin_command();
      material_ = material;
      expected_ = samples;
      period_s_ = period_s;
      set_state(DeviceState::kStaged, "arming", fx);
      call(kArm, "arm",
           {{"material", {double(material)}}, {"samples", {double(samples)}}, {"period_s", {period_s}}},
           now_us);
    }
  }
  pump(now_us, fx);
}

void ScriptPoint::collect(std::int64_t now_us, Effects& fx) {
  if (accepts(fx) && !lacks("collect", fx)) {
    begin_command();
    call(kCollect, "collect", {}, now_us);
  }
  pump(now_us, fx);
}

void ScriptPoint::reading(std::int64_t now_us, Effects& fx) {
  if (accepts(fx)) {
    begin_command();
    call(kReading, "reading", {}, now_us);
  }
  pump(now_us, fx);
}

void ScriptPoint::returned(std::uint16_t tag, const Line& line, std::int64_t now_us, Effects& fx) {
  if (tag == kArm) {
    set_state(DeviceState::kArmed, "waiting for the signal", fx);
    return finish({Outcome::kReady, -1, expected_, 0, 0, kNoCode, ""}, fx);
  }
  const auto value = line.values.find("value");
  const std::size_t most = tag == kReading ? 1 : std::size_t(expected_);
  if (value == line.values.end() || (tag == kReading && value->second.size() != 1) ||
      value->second.size() > most)
    return wrong(tag == kReading ? "reading" : "collect",
                 "it returns " + std::to_string(value == line.values.end() ? 0 : value->second.size()) +
                     " values; asked for were " + std::to_string(most),
                 now_us, fx);
  std::vector<float> z_mm(value->second.begin(), value->second.end());
  const auto counted = std::int64_t(z_mm.size());
  if (tag == kReading) {
    fx.measured<LaserPointDriver>(Samples{material_, 1, 0, 0.0, std::move(z_mm)});
    return finish({Outcome::kDone, counted, 1, 0, 0, kNoCode, ""}, fx);
  }
  set_state(DeviceState::kSafe, "collected", fx);
  fx.measured<LaserPointDriver>(Samples{material_, expected_, 0, period_s_, std::move(z_mm)});
  finish({Outcome::kDone, counted, expected_, 0, 0, kNoCode, ""}, fx);
}

}  // namespace firn::drivers
