// GrblStage: connection, holding, setting up, and the words of the board.
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "drivers/stage/grbl_stage.h"

namespace firn::drivers {

using grbl::fixed;

namespace {

constexpr std::int64_t kStands_us = 3'000'000;  // longest deceleration of a hold
constexpr double kNoSetting = std::numeric_limits<double>::quiet_NaN();
constexpr double kSameAcceleration = 0.99;  // a run-up that the board needs longer for would be short

}  // namespace

void GrblStage::connected(std::int64_t now_us, Effects& fx) {
  if (std::exchange(set_up_next_, false)) return set_up();
  if (phase_ == Phase::kHolding) return;  // it only forgot its question
  set_state(DeviceState::kIdentifying, identity_, fx);
  hold({}, kNoCode, now_us, fx);  // whatever it was doing
}

// The hold decelerates, so that the place is kept; a reset of a board that moves would lose it.
void GrblStage::hold(std::string why, std::int32_t code, std::int64_t now_us, Effects& fx) {
  if (!why.empty() && ending_.empty()) {
    ending_ = std::move(why);
    ending_code_ = code;
  }
  stopping_ = true;
  if (phase_ == Phase::kHolding) return;
  phase_ = Phase::kHolding;
  link_.opened(now_us);  // of lines that it has taken no answer is awaited
  lines_.clear();
  next_line_ = 0;
  for (const char byte : {grbl::kHold, grbl::kStatus}) fx.tx.push_back(std::byte(byte));
  ask_us_ = now_us + kAskMoving_us;
  until_us_ = now_us + kStands_us + std::int64_t(config_.host_latency_s * 1e6);
}

// It stands. Lines that it has taken are forgotten by the reset, and with them their answers.
void GrblStage::halted(std::int64_t now_us, Effects&) {
  set_up_next_ = true;
  link_.opened(now_us);
  phase_ = Phase::kSetup;
}

void GrblStage::set_up() {
  phase_ = Phase::kSetup;
  settings_.clear();
  link_.push(grbl::reset(kBoot));
  link_.push(grbl::line("$I", kPlain, Repeat::kRead));
  link_.push(grbl::line("$$", kPlain, Repeat::kRead));
  link_.push(grbl::status(kLook));
}

double GrblStage::setting(int number) const {
  const auto at = settings_.find(number);
  return at == settings_.end() ? kNoSetting : at->second;
}

std::string GrblStage::setting_text(int number) const {
  return "$" + std::to_string(number) + fixed(" = %g", setting(number));
}

// Why the board is not the one of the lab file (interlock 14); empty: it is.
std::string GrblStage::mismatch() const {
  if (!on(config_.check_parameters)) return {};
  if (setting(grbl::kInches) != 0.0) return setting_text(grbl::kInches) + ": it reports inches; set $13=0";
  for (int axis = 0; axis < 3; ++axis) {
    const char letter = kAxisNames[axis];
    const double steps = setting(grbl::kSteps + axis), rate = setting(grbl::kMaxRate + axis) / 60.0,
                 acceleration = setting(grbl::kAcceleration + axis);
    if (!(steps > 0.0)) return std::string("it tells no steps of axis ") + letter;
    if (axis < 2 && std::abs(steps - config_.counts_per_mm) > 1e-3 * config_.counts_per_mm)
      return setting_text(grbl::kSteps + axis) +
             fixed(" steps/mm; stage.counts_per_mm = %g", config_.counts_per_mm);
    if (axis < 2 && !(rate >= config_.max_speed_mm_s * (1.0 - 1e-6)))
      return setting_text(grbl::kMaxRate + axis) + fixed(" mm/min = %g mm/s", rate) +
             fixed("; stage.max_speed_mm_s = %g", config_.max_speed_mm_s);
    if (axis < 2 && !(acceleration >= kSameAcceleration * config_.acceleration_mm_s2))
      return setting_text(grbl::kAcceleration + axis) +
             fixed(" mm/s^2; stage.acceleration_mm_s2 = %g, and runs-up are planned with it",
                   config_.acceleration_mm_s2);
  }
  if (on(config_.laser_output) && setting(grbl::kLaserMode) != 1.0)
    return setting_text(grbl::kLaserMode) + ": without laser mode the board stops at each droplet; set $32=1";
  if (on(config_.laser_output) && !(setting(grbl::kMaxPower) > 0.0))
    return setting_text(grbl::kMaxPower) + ": no power";
  return {};
}

void GrblStage::die(std::int32_t code, const std::string& why, Effects& fx) {
  phase_ = Phase::kDead;
  stopping_ = false;
  link_.clear_queue();
  set_state(DeviceState::kFault, why, fx);
  fault(Severity::kStop, code, "stage: " + why, fx);
  if (busy()) {
    if (ending_.empty()) ending_ = why;
    ending_code_ = code;
    settled(fx);
  }
}

// After the settings: the board about itself.
void GrblStage::look_around(const grbl::Report& report, Effects& fx) {
  if (const std::string why = mismatch(); !why.empty()) return die(kLimit, why, fx);
  const bool can_home = setting(grbl::kHoming) != 0.0;
  if (report.state == grbl::State::kDoor || report.state == grbl::State::kSleep)
    return die(kInstrument, report.state == grbl::State::kDoor ? "its safety door is open" : "it sleeps", fx);
  identified();
  if (report.state == grbl::State::kAlarm) {
    homed_ = false;
    if (!can_home)
      return die(kAxisFault, "it is in alarm and cannot home ($22 = 0): unlock it by hand ($X) and place it",
                 fx);
    if (was_homed_) return die(kAxisFault, "it is in alarm, its place is lost: home it", fx);
    if (on(config_.home_at_start)) {
      phase_ = Phase::kHoming;
      set_state(DeviceState::kActive, "homing", fx);
      return push_homing();
    }
  } else {
    // A board with switches that is not homed is in alarm; one without stands where a person has put it.
    homed_ = was_homed_ = true;
    for (const char* text : {"G21", "G90", "G94", "G54", "M5 S0", "M9"})
      link_.push(grbl::line(text, kPlain, Repeat::kSetup));
  }
  phase_ = Phase::kReady;
  stopping_ = false;
  set_state(DeviceState::kSafe, ending_.empty() ? "at rest" : ending_, fx);
  if (busy()) settled(fx);
  ending_.clear();
}

void GrblStage::push_homing() {
  link_.push(grbl::line("$H", kHomed, Repeat::kNever, std::int64_t(3.0 * config_.home_timeout_s * 1e6)));
}

void GrblStage::reply(const Request& request, std::span<const std::byte> frame, std::int64_t now_us,
                      Effects& fx) {
  const std::string_view text = grbl::text_of_line(frame);
  if (text.starts_with("error:")) {
    const std::string why = "it refuses '" + std::string(request.text().substr(0, request.size - 1u)) +
                            "': " + grbl::meaning_of(text);
    if (request.tag == kHomed || phase_ == Phase::kSetup) return die(kAxisFault, why, fx);
    fault(Severity::kStop, kCommandRejected, "stage: " + why, fx);
    return hold(why, kCommandRejected, now_us, fx);
  }
  switch (request.tag) {
    case kBoot:
      identity_ = std::string(text.substr(0, text.find(" [")));
      return;
    case kLook:
      if (const auto report = grbl::parse_report(text)) {
        take(*report, now_us, fx);
        if (phase_ == Phase::kSetup) look_around(*report, fx);
      }
      return;
    case kHomed:
      homed_ = was_homed_ = true;
      if (op_ == Op::kHome) finish({Outcome::kDone, -1, 0, 0, 0, kNoCode, ""}, fx);
      phase_ = Phase::kSetup;  // homing may have changed its words: look again
      link_.push(grbl::status(kLook));
      return;
    default:
      return;
  }
}

void GrblStage::failed(const Request& request, std::int64_t now_us, Effects& fx) {
  if (phase_ == Phase::kHolding) return;
  const std::string why = "no good reply to '" + std::string(request.text().substr(0, request.size - 1u)) +
                          "'" + not_understood();
  fault(Severity::kWarning, kLinkLost, "stage: " + why, fx);
  if (phase_ == Phase::kSetup || phase_ == Phase::kHoming) return reconnect(now_us, fx, why);
  hold(why, kLinkLost, now_us, fx);
}

void GrblStage::unsolicited(std::span<const std::byte> frame, std::int64_t now_us, Effects& fx) {
  const std::string_view text = grbl::text_of_line(frame);
  if (const auto report = grbl::parse_report(text)) return take(*report, now_us, fx);
  if (const auto setting = grbl::parse_setting(text)) {
    settings_[setting->first] = setting->second;
  } else if (text.starts_with("[VER:")) {
    const std::string_view version = text.substr(5, text.size() - 6);
    identity_ = "GRBL " + std::string(version);
  } else if (text.starts_with("ALARM:")) {
    homed_ = false;
    const std::string why = grbl::meaning_of(text);
    fault(Severity::kStop, kAxisFault, "stage: " + why, fx);
    if (phase_ != Phase::kHolding && phase_ != Phase::kDown) hold(why, kAxisFault, now_us, fx);
  } else if (text.starts_with("Grbl ") && phase_ != Phase::kHolding && phase_ != Phase::kSetup) {
    homed_ = false;  // it has had no power: its place and its lines are gone
    fault(Severity::kStop, kAxisFault, "stage: the board has started anew: its place is lost", fx);
    hold("the board has started anew", kAxisFault, now_us, fx);
  }
}

void GrblStage::take(const grbl::Report& report, std::int64_t now_us, Effects& fx) {
  using grbl::State;
  if (report.offset_mm) offset_mm_ = *report.offset_mm;
  for (std::size_t a = 0; a < 3; ++a)
    position_mm_[a] = report.place_mm[a] - (report.of_machine ? offset_mm_[a] : 0.0);
  const bool stands = report.state == State::kIdle || report.state == State::kHoldComplete ||
                      report.state == State::kAlarm || report.state == State::kSleep ||
                      report.state == State::kDoor;
  if (phase_ == Phase::kHolding) {
    if (stands) halted(now_us, fx);
    return;
  }
  if (report.state == State::kDoor && phase_ != Phase::kDown && phase_ != Phase::kSetup) {
    fault(Severity::kStop, kEstop, "stage: its safety door is open", fx);
    return hold("its safety door is open", kEstop, now_us, fx);
  }
  if (phase_ == Phase::kPlacing) return go_on(now_us, fx);
  const bool sent = next_line_ >= lines_.size();
  if ((phase_ == Phase::kToStart || phase_ == Phase::kRunning) && sent && report.state == State::kIdle)
    arrived(now_us, fx);
}

void GrblStage::lost(std::int64_t, Effects& fx) {
  if (phase_ == Phase::kDown) return;
  if (busy()) {
    fault(Severity::kStop, kLinkLost,
          "stage: link lost while in use; the board goes on to the end of the lines that it holds", fx);
    if (ending_.empty()) ending_ = "the link was lost";
    ending_code_ = kLinkLost;
  } else {
    fault(Severity::kWarning, kLinkLost, "stage: link lost", fx);
  }
  phase_ = Phase::kDown;
  stopping_ = false;
  set_up_next_ = false;
}

void GrblStage::stop(std::int64_t now_us, Effects& fx) {
  if (phase_ == Phase::kDown || phase_ == Phase::kSetup || phase_ == Phase::kDead) return;
  hold("safe stop", kNoCode, now_us, fx);
}

}  // namespace firn::drivers
