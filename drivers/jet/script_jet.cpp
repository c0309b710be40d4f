#include "drivers/jet/script_jet.h"

#include <cmath>
#include <utility>

namespace firn::drivers {
namespace {

constexpr std::int64_t kAskArmed_us = 1'000'000;

}  // namespace

ScriptJet::ScriptJet(ScriptOptions script) : ScriptDriver(std::move(script), {"arm", "disarm"}) {}

void ScriptJet::arm(std::int64_t expected, std::int64_t now_us, Effects& fx) {
  if (accepts(fx)) {
    begin_command();
    acts();
    expected_ = expected;
    not_armed_.clear();
    armed_until_us_ = 0;
    set_state(DeviceState::kStaged, "arming", fx);
    call(kArm, "arm", {{"expected", {double(expected)}}}, now_us);
  }
  pump(now_us, fx);
}

void ScriptJet::arm_small(std::int64_t, std::int64_t now_us, Effects& fx) {
  refuse(kInstrument, script().class_name + " has one size of droplet", fx);
  pump(now_us, fx);
}

void ScriptJet::disarm(std::int64_t now_us, Effects& fx) {
  if (accepts(fx)) {
    begin_command();
    if (armed_) acts();
    call(kDisarm, "disarm", {}, now_us);
  }
  pump(now_us, fx);
}

void ScriptJet::jet(std::int64_t now_us, Effects& fx) {
  refuse(kNoCode, script().class_name + " does not jet for the camera", fx);
  pump(now_us, fx);
}

Result ScriptJet::ended(Outcome outcome, std::int64_t counted, std::int32_t code, std::string text) const {
  Result r{outcome, counted, expected_, 0, 0, code, std::move(text)};
  if (outcome == Outcome::kUnknown) r.unknown_to = expected_;
  r.until_us = armed_until_us_;
  return r;
}

// Of a jet that was armed, or may have been, nobody knows how many triggers it has seen.
Result ScriptJet::broken_off(Outcome outcome, std::int32_t code, std::string text) {
  const bool in_doubt = outcome == Outcome::kUnknown || (outcome == Outcome::kFailed && armed_until_us_ == 0);
  return ended(in_doubt ? Outcome::kUnknown : outcome, -1, code, std::move(text));
}

void ScriptJet::returned(std::uint16_t tag, const Line& line, std::int64_t now_us, Effects& fx) {
  switch (tag) {
    case kArm:
      armed_ = true;
      ask_us_ = now_us + kAskArmed_us;
      set_state(DeviceState::kArmed, "external trigger", fx);
      return finish(ended(Outcome::kReady, -1, kNoCode, {}), fx);
    case kArmed:
      ask_us_ = now_us + kAskArmed_us;
      if (line.number("value") != 0.0) return;
      not_armed_ = "armed() returned False";
      fault(Severity::kStop, kInstrument, "jet: " + script().file + ": " + not_armed_, fx);
      return make_safe(not_armed_, kInstrument, now_us, fx);
    case kDisarm: {
      armed_ = false;
      end_acting();
      set_state(DeviceState::kSafe, "disarmed", fx);
      const double counted = line.number("value");  // NaN: it does not count
      if (counted < 0.0 || counted != std::floor(counted)) {
        if (!std::isnan(counted)) return wrong("disarm", "it returns no count", now_us, fx);
      }
      if (!not_armed_.empty())
        return finish(ended(Outcome::kUnknown, -1, kInstrument,
                            "the jet was not seen armed during the whole pass: " + not_armed_),
                      fx);
      return finish(ended(Outcome::kDone, std::isnan(counted) ? -1 : std::int64_t(counted), kNoCode, {}), fx);
    }
    default:
      return;
  }
}

// A stop disarms; the stage may go on triggering for a moment, so the count of droplets ends here.
void ScriptJet::became_safe(std::int64_t now_us, Effects&) {
  if (armed_ && armed_until_us_ == 0) armed_until_us_ = now_us;
  armed_ = false;
}

void ScriptJet::program_lost(Effects&) {
  if (armed_ && not_armed_.empty()) not_armed_ = "its program was lost while it was armed";
  armed_ = false;
}

bool ScriptJet::work(std::int64_t now_us, Effects&) {
  if (!armed_ || !has("armed") || now_us < ask_us_) return false;
  call(kArmed, "armed", {}, now_us);
  return true;
}

std::int64_t ScriptJet::work_wake_us() const { return armed_ && has("armed") && !waits() ? ask_us_ : 0; }

}  // namespace firn::drivers
