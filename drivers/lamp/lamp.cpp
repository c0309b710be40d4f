#include "drivers/lamp/lamp.h"
#include "core/options/number.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace firn::drivers {
namespace {

constexpr std::int64_t kTimerGrace_us =
    200'000;  // the instrument's timer closes the shutter; CLS after it is the belt
constexpr std::int64_t kOverdueGrace_us = 500'000;

}  // namespace

using omnicure::Format;

Lamp::Lamp(LampOptions config)
    : LampDriver(dialect_),
      config_(std::move(config)),
      silence_(std::int64_t(config_.poll_idle_s * 1e6), dialect_) {
  check_options("lamp", kLampConfig, config_);
  dialect_.table = config_.dialect;
  dialect_.allow_host_latency(config_.host_latency_s);
  identity_ = "Excelitas OmniCure S2000";
}

void Lamp::push(std::string_view text, Format format, Repeat repeat, Tag tag) {
  link_.push(omnicure::request(text, format, repeat, tag));
}

void Lamp::connected(std::int64_t, Effects& fx) {
  set_state(DeviceState::kIdentifying, identity_, fx);
  phase_ = Phase::kConnecting;
  told_on_ = releasing_ = false;
  push(config_.dialect.connect, omnicure::kReady, Repeat::kSetup, kConnect);
}

void Lamp::finish(Outcome outcome, std::int32_t code, std::string text, Effects& fx) {
  exposing_ = false;
  ending_.clear();
  ending_code_ = kNoCode;
  fx.events.emplace_back(Result{outcome, -1, 0, 0, 0, code, std::move(text)});
}

void Lamp::begin_exposure(double exposure_s, int iris_percent, std::int64_t now_us, Effects& fx) {
  std::string why = exposure_refusal(exposure_s, iris_percent, config_);
  std::int32_t code = kLimit;
  if (busy() || phase_ != Phase::kReady) {
    why = std::string("the lamp is ") + (busy() ? "busy with another command" : standing());
    code = kNoCode;
  } else if (!barred_.empty()) {
    why = barred_;
    code = kLampOn;
  }
  if (!why.empty()) {
    fx.events.emplace_back(Result{Outcome::kRefused, -1, 0, 0, 0, code, why});
  } else {
    exposing_ = true;
    opened_ = false;
    exposure_us_ = std::llround(exposure_s * 1e6);
    tenths_ = exposure_us_ / 100'000;
    by_instrument_ = config_.instrument_timer && tenths_ > 0 && tenths_ * 100'000 == exposure_us_;
    iris_percent_ = iris_percent;
    seen_open_ = false;
    if (on(config_.status_bits)) {
      phase_ = Phase::kChecking;
      ask_until_us_ = now_us + std::int64_t(config_.warm_up_s * 1e6);
      ask_status(now_us);
      set_state(DeviceState::kStaged, "status", fx);
    } else {
      prepare(fx);
    }
  }
}

void Lamp::prepare(Effects& fx) {
  phase_ = Phase::kPreparing;
  if (iris_percent_ != kKeepIris)
    push(config_.dialect.iris + std::to_string(iris_percent_), omnicure::kReceived, Repeat::kSetup, kPlain);
  if (by_instrument_) {
    push(config_.dialect.set_time + std::to_string(tenths_), omnicure::kReceived, Repeat::kSetup, kSetTime);
    push(config_.dialect.get_time, omnicure::kAny, Repeat::kRead, kGetTime);
  }
  set_state(DeviceState::kStaged, "iris and time", fx);
}

void Lamp::close_shutter(std::int64_t now_us, Effects& fx) {
  const Request close = omnicure::request(config_.dialect.close, omnicure::kReceived, Repeat::kSetup, kClose);
  link_.clear_queue();
  link_.urgent(close, now_us, fx);
  if (link_.suspect()) link_.push(close);  // on a suspect link the first answer is drained
  phase_ = Phase::kClosing;
  seen_closed_ = !on(config_.status_bits);
  ask_at_us_ = now_us;
  ask_until_us_ = 0;  // begins when the lamp has answered
}

void Lamp::stop(std::int64_t now_us, Effects& fx) {
  if (phase_ == Phase::kDown || phase_ == Phase::kConnecting || phase_ == Phase::kWaiting ||
      phase_ == Phase::kReleased) {
    // Not connected to it: a CLS that it understands helps, one that it does not does no harm.
    if (may_be_open())
      link_.urgent(omnicure::request(config_.dialect.close, omnicure::kReceived, Repeat::kSetup, kClose),
                   now_us, fx);
    return;
  }
  if (phase_ == Phase::kClosing) return;
  if (exposing_) {
    ending_ = "safe stop";
    ending_code_ = kNoCode;
  }
  close_shutter(now_us, fx);
}

void Lamp::release(std::int64_t now_us, Effects& fx) {
  silence_.end();
  if (link_.is_open() && phase_ != Phase::kDown && phase_ != Phase::kReleased) {
    close_shutter(now_us, fx);
    releasing_ = on(config_.status_bits);  // once the bits say that it is closed
    if (!releasing_) push(config_.dialect.disconnect, omnicure::kClosed, Repeat::kSetup, kDisconnect);
  }
  pump(now_us, fx);
}

void Lamp::tick(std::int64_t now_us, Effects& fx) {
  if (phase_ == Phase::kExposing) silence_.heard(now_us);  // nothing is asked meanwhile
  if (silence_.is_over(now_us)) fault(Severity::kStop, kLinkLost, "lamp: " + silence_.words(), fx);
  if (phase_ == Phase::kExposing && now_us >= close_at_us_) close_shutter(now_us, fx);
  if (may_be_open() && !overdue_told_ &&
      now_us - open_since_us_ >= std::int64_t(config_.max_on_s * 1e6) + kOverdueGrace_us) {
    overdue_told_ = true;
    fault(Severity::kStop, kLampOn, "lamp: the shutter may have been open longer than allowed", fx);
    if (phase_ != Phase::kDown) close_shutter(now_us, fx);
  }
}

void Lamp::reply(const Request& request, std::span<const std::byte> frame, std::int64_t now_us, Effects& fx) {
  const std::string_view text = omnicure::OmnicureDialect::text(frame);
  const bool error = text.starts_with(config_.dialect.error);
  if (phase_ == Phase::kReady || silence_.wake_us() != 0) silence_.heard(now_us);
  switch (request.tag) {
    case kConnect:
      if (error) {
        phase_ = Phase::kWaiting;
        again_at_us_ = now_us + std::int64_t(config_.connect_every_s * 1e6);
        return;
      }
      close_shutter(now_us, fx);
      push(config_.dialect.version, omnicure::kAny, Repeat::kRead, kVersion);
      return;
    case kVersion:
      if (!error) identity_ = "Excelitas OmniCure S2000 board " + std::string(text);
      return;
    case kSetTime:
      if (error) by_instrument_ = false;
      return;
    case kGetTime: {
      if (error || whole_number<std::int64_t>(text) != tenths_) by_instrument_ = false;
      return;
    }
    case kOpen:
      if (error) {
        ending_ = "the lamp refuses '" + std::string(request.text().substr(0, 3)) + "'";
        ending_code_ = kCommandRejected;
        close_shutter(now_us, fx);
        return;
      }
      if (phase_ != Phase::kOpening) return;  // a stop came between
      phase_ = Phase::kExposing;
      close_at_us_ = now_us + exposure_us_ + (by_instrument_ ? kTimerGrace_us : 0);
      expect_open(now_us);
      set_state(DeviceState::kActive, by_instrument_ ? "exposing by its own timer" : "exposing", fx);
      return;
    case kClose:
      if (error) {
        fault(Severity::kStop, kLampOn, "lamp: it refuses to close the shutter", fx);
        return reconnect(now_us, fx, "it refuses to close the shutter");
      }
      if (!on(config_.status_bits)) open_since_us_ = 0;
      return;
    case kStatus: {
      const auto bits = whole_number<std::uint32_t>(text);
      if (error || !bits)
        return reconnect(now_us, fx,
                         "it answers '" + config_.dialect.status + "' with '" + std::string(text) + "'");
      return status(*bits, now_us, fx);
    }
    case kDisconnect:
      phase_ = Phase::kReleased;
      return;
    default:
      if (error && (phase_ == Phase::kPreparing || phase_ == Phase::kChecking)) {
        ending_ = "the lamp refuses '" + std::string(request.text().substr(0, request.size - 3u)) + "'" +
                  not_understood();
        ending_code_ = kCommandRejected;
        close_shutter(now_us, fx);
      }
  }
}

void Lamp::failed(const Request& request, std::int64_t now_us, Effects& fx) {
  const std::string why =
      "no good reply to '" + std::string(request.text().substr(0, request.size - 3u)) + "'";
  fault(request.tag == kConnect ? Severity::kNotice : Severity::kWarning, kLinkLost, "lamp: " + why, fx);
  if (phase_ == Phase::kClosing && request.tag == kOpen) return;
  if (request.tag != kOpen) return reconnect(now_us, fx, why);
  ending_ = why;  // it may be open
  ending_code_ = kLinkLost;
  close_shutter(now_us, fx);
}

void Lamp::lost(std::int64_t, Effects& fx) {
  if (phase_ == Phase::kDown) return;
  if (may_be_open()) fault(Severity::kStop, kLampOn, "lamp: link lost with the shutter open", fx);
  if (exposing_ && ending_.empty()) {
    ending_ = "the link was lost";
    ending_code_ = kLinkLost;
  }
  phase_ = Phase::kDown;
}

bool Lamp::idle(std::int64_t now_us, Effects& fx) {
  switch (phase_) {
    case Phase::kWaiting:
      if (now_us < again_at_us_) return false;
      phase_ = Phase::kConnecting;
      push(config_.dialect.connect, omnicure::kReady, Repeat::kSetup, kConnect);
      return true;
    case Phase::kPreparing:
      phase_ = Phase::kOpening;
      open_since_us_ = now_us;  // from here on nobody knows until CLS is answered
      opened_ = true;
      overdue_told_ = false;
      push(by_instrument_ ? config_.dialect.run : config_.dialect.open, omnicure::kReceived, Repeat::kNever,
           kOpen);
      return true;
    case Phase::kExposing:
      return !seen_open_ && on(config_.status_bits) && ask_again(now_us);
    case Phase::kChecking:
      return ask_again(now_us);
    case Phase::kClosing:
      if (!seen_closed_) return ask_again(now_us);
      if (releasing_) {
        releasing_ = false;
        push(config_.dialect.disconnect, omnicure::kClosed, Repeat::kSetup, kDisconnect);
        return true;
      }
      if (exposing_ && opened_ && on(config_.status_bits) && !seen_open_ && ending_.empty()) {
        ending_ = "the shutter was not seen open";
        ending_code_ = kLampOn;
        fault(Severity::kStop, kLampOn, "lamp: " + ending_, fx);
      }
      identified();
      phase_ = Phase::kReady;
      silence_.heard(now_us);
      set_state(DeviceState::kSafe, "shutter closed", fx);
      if (!exposing_) return false;
      if (ending_.empty())
        finish(Outcome::kDone, kNoCode, {}, fx);
      else if (!opened_ || ending_code_ == kCommandRejected)
        finish(Outcome::kNone, ending_code_, ending_, fx);
      else
        finish(ending_code_ == kLinkLost ? Outcome::kUnknown : Outcome::kFailed, ending_code_, ending_, fx);
      return false;
    case Phase::kReady:
      if (now_us - link_.last_sent_us() < std::int64_t(config_.poll_idle_s * 1e6)) return false;
      push(config_.dialect.status, omnicure::kAny, Repeat::kRead, on(config_.status_bits) ? kStatus : kPlain);
      return true;
    default:
      return false;
  }
}

std::int64_t Lamp::device_wake_us() const {
  const std::int64_t work_us = work_wake_us();
  const std::int64_t silent_us = phase_ == Phase::kExposing ? 0 : silence_.wake_us();
  return work_us == 0 ? silent_us : silent_us == 0 ? work_us : std::min(work_us, silent_us);
}

std::int64_t Lamp::work_wake_us() const {
  if (phase_ == Phase::kExposing)
    return on(config_.status_bits) && !seen_open_ && link_.idle() ? std::min(close_at_us_, ask_at_us_)
                                                                  : close_at_us_;
  if (link_.idle() && (phase_ == Phase::kChecking || (phase_ == Phase::kClosing && !seen_closed_)))
    return ask_at_us_;
  if (may_be_open() && !overdue_told_)
    return open_since_us_ + std::int64_t(config_.max_on_s * 1e6) + kOverdueGrace_us;
  if (!link_.idle()) return 0;
  if (phase_ == Phase::kWaiting) return again_at_us_;
  if (phase_ == Phase::kReady) return link_.last_sent_us() + std::int64_t(config_.poll_idle_s * 1e6);
  return 0;
}

// Orders of a person, beside a print (firn device).
void Lamp::service(std::string_view verb, std::span<const double> v, std::int64_t now_us, Effects& fx) {
  const LampDialect& d = config_.dialect;
  const auto line = [](const std::string& text, omnicure::Format format, Repeat repeat) {
    return omnicure::request(text, format, repeat, kServiceTag);
  };
  const auto told = [&d](std::string before) {
    return [&d, before = std::move(before)](const Request&,
                                            std::span<const std::byte> frame) -> std::optional<std::string> {
      const std::string_view text = omnicure::OmnicureDialect::text(frame);
      if (text.starts_with(d.error)) return std::nullopt;
      return before.empty() ? std::string() : before + std::string(text);
    };
  };
  Service s{std::string(verb), {}, 0, {}, told("")};
  if (verb == "shutter" && v.size() == 1) return begin_exposure(v[0], kKeepIris, now_us, fx);
  if (verb == "on" && v.empty()) {
    s.begin = {line(d.lamp_on, omnicure::kReceived, Repeat::kSetup)};
  } else if (verb == "off" && v.empty()) {
    s.begin = {line(d.close, omnicure::kReceived, Repeat::kSetup),
               line(d.lamp_off, omnicure::kReceived, Repeat::kSetup)};
  } else if (verb == "iris" && v.size() == 1) {
    if (!(v[0] >= 1 && v[0] <= 100) || v[0] != std::floor(v[0]))
      return refuse_service(kLimit, "an iris is a whole number of percent, 1 to 100", fx);
    s.begin = {line(d.iris + std::to_string(int(v[0])), omnicure::kReceived, Repeat::kSetup)};
  } else if (verb == "hours" && v.empty()) {
    s.begin = {line(d.hours, omnicure::kAny, Repeat::kRead)};
    s.tell = told("lamp hours ");
  } else if (verb == "serial" && v.empty()) {
    s.begin = {line(d.serial, omnicure::kAny, Repeat::kRead)};
    s.tell = told(identity_ + " serial ");
  } else {
    return Driver::service(verb, v, now_us, fx);
  }
  run_service(std::move(s));
}

}  // namespace firn::drivers
