// Lamp: what its status bits say before, during and after an exposure.
#include "drivers/lamp/lamp.h"

namespace firn::drivers {
namespace {

constexpr std::int64_t kShutterMoves_us = 500'000;  // the status bit follows the shutter within it
constexpr std::int64_t kAskShutter_us = 100'000, kAskWarmth_us = 1'000'000;

}  // namespace

void Lamp::ask_status(std::int64_t now_us) {
  push(config_.dialect.status, omnicure::kAny, Repeat::kRead, kStatus);
  ask_at_us_ = now_us + (phase_ == Phase::kChecking ? kAskWarmth_us : kAskShutter_us);
}

bool Lamp::ask_again(std::int64_t now_us) {
  if (now_us < ask_at_us_) return false;
  ask_status(now_us);
  return true;
}

void Lamp::expect_open(std::int64_t now_us) {
  ask_at_us_ = now_us;
  ask_until_us_ = now_us + kShutterMoves_us;
}

void Lamp::fail_exposure(std::string why, std::int64_t now_us, Effects& fx) {
  fault(Severity::kStop, kLampOn, "lamp: " + why, fx);
  ending_ = std::move(why);
  ending_code_ = kLampOn;
  close_shutter(now_us, fx);
}

void Lamp::bar(std::string_view why, std::int64_t now_us, Effects& fx) {
  barred_ = why;
  if (!barred_.empty() && exposing_ && phase_ != Phase::kClosing && phase_ != Phase::kDown)
    fail_exposure(barred_, now_us, fx);
  pump(now_us, fx);
}

// A lamp that burns and is not warm is waited for; one that does not burn is switched on once.
void Lamp::check_before(std::uint32_t bits, std::int64_t now_us, Effects& fx) {
  const bool off = !(bits & omnicure::kBurning) && omnicure::trouble(bits | omnicure::kBurning).empty();
  if (off && on(config_.auto_on) && !told_on_) {
    told_on_ = true;
    fault(Severity::kNotice, kLampOn, "lamp: it does not burn and is switched on", fx);
    push(config_.dialect.lamp_on, omnicure::kReceived, Repeat::kSetup, kPlain);
    return;
  }
  const bool starting = off && told_on_;
  if (const auto why = omnicure::trouble(bits); !why.empty() && !starting)
    return fail_exposure(std::string(why), now_us, fx);
  if (bits & omnicure::kWarm && !starting) return prepare(fx);
  if (now_us >= ask_until_us_) fail_exposure(starting ? "it does not burn" : "it is not warm", now_us, fx);
}

void Lamp::status(std::uint32_t bits, std::int64_t now_us, Effects& fx) {
  const bool open = bits & omnicure::kShutterOpen;
  switch (phase_) {
    case Phase::kChecking:
      return check_before(bits, now_us, fx);
    case Phase::kExposing:
      seen_open_ = seen_open_ || open;
      if (!seen_open_ && now_us >= ask_until_us_) fail_exposure("the shutter does not open", now_us, fx);
      return;
    case Phase::kClosing:
      seen_open_ = seen_open_ || open;  // the answer to a question before the shutter was told to close
      seen_closed_ = !open;
      if (seen_closed_) {
        open_since_us_ = 0;
        return;
      }
      if (ask_until_us_ == 0) ask_until_us_ = now_us + kShutterMoves_us;
      if (now_us < ask_until_us_) return;
      fault(Severity::kStop, kLampOn, "lamp: the shutter does not close", fx);
      return reconnect(now_us, fx, "the shutter does not close");
    case Phase::kReady:
      if (!open) return;
      fault(Severity::kStop, kLampOn, "lamp: the shutter is open, and nobody opened it", fx);
      open_since_us_ = now_us;
      overdue_told_ = false;
      return close_shutter(now_us, fx);
    default:
      return;
  }
}

}  // namespace firn::drivers
