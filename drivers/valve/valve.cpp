#include "drivers/valve/valve.h"

#include <algorithm>
#include <cmath>

namespace firn::drivers {

using fvb::Type;

namespace {

std::string milliseconds(int us) {
  return std::to_string(us / 1000) + '.' + std::to_string(1000 + us % 1000).substr(1);
}

// Why a list is not for this valve and its microcontroller; empty = it is.
Violation broken_train_limit(const ValveOptions& c, const fvb::Hello& firmware, double tick_s, double pulse_s,
                             std::span<const std::int32_t> ticks) {
  const double tick_us = std::round(tick_s * 1e6), pulse_us = std::round(pulse_s * 1e6);
  if (!(tick_us >= 1.0 && tick_us <= 65'535.0)) return {"a tick of " + std::to_string(tick_s) + " s"};
  if (!(pulse_us >= fvb::kMinPulse_us && pulse_us <= firmware.max_pulse_us))
    return {"a pulse of " + std::to_string(pulse_s * 1e3) + " ms is outside [0.5, " +
                milliseconds(firmware.max_pulse_us) + "] ms",
            {pulse_s * 1e3, pulse_us > fvb::kMinPulse_us ? firmware.max_pulse_us * 1e-3 : 0.5, "ms"}};
  const int guard_us = int(std::lround(c.guard_us));
  if (ticks.empty() || ticks.size() > firmware.max_entries)
    return {std::to_string(ticks.size()) + " pulses are outside [1, " + std::to_string(firmware.max_entries) +
                "]",
            {double(ticks.size()), ticks.empty() ? 1.0 : double(firmware.max_entries)}};
  constexpr double kExcess_us = 2e6;  // of open time above the duty, which the firmware allows
  const double duty = firmware.max_duty_percent / 100.0;
  double heat_us = 0.0;
  for (std::size_t n = 0; n < ticks.size(); ++n) {
    if (ticks[n] < 0 || ticks[n] > 65'535)
      return {"pulse " + std::to_string(n) + ": tick " + std::to_string(ticks[n]) + " is outside [0, 65535]",
              {double(ticks[n]), ticks[n] < 0 ? 0.0 : 65'535.0}};
    heat_us += pulse_us * (1.0 - duty);
    if (heat_us >= kExcess_us * (1.0 - duty) && duty < 1.0)
      return {"pulse " + std::to_string(n) + " keeps the coil on for more than " +
                  std::to_string(firmware.max_duty_percent) + " % of the time",
              {100.0, double(firmware.max_duty_percent), "%"}};
    if (n + 1 < ticks.size())
      heat_us = std::max(0.0, heat_us - (double(ticks[n + 1] - ticks[n]) * tick_us - pulse_us) * duty);
    if (n == 0) continue;
    const double gap_us = (double(ticks[n]) - double(ticks[n - 1])) * tick_us;
    if (gap_us < pulse_us + guard_us)
      return {"pulse " + std::to_string(n) + " begins " + std::to_string(std::int64_t(gap_us)) +
                  " us after the one before, less than pulse and guard of " +
                  std::to_string(std::int64_t(pulse_us) + guard_us) + " us",
              {gap_us, pulse_us + guard_us, "us"}};
  }
  return {};
}

constexpr int kMaxTries = 3;

}  // namespace

std::string ListName::text() const {
  return "list " + std::to_string(list) + " of path " + std::to_string(path);
}

Valve::Valve(ValveOptions config)
    : Driver(dialect_), name_(config.valve == 2 ? "valve_b" : "valve_a"), config_(config) {
  check_options(name_, kValveDriveConfig, config_);
  check_options(name_, kValveDialect, config_.dialect, "dialect.");
  dialect_.allow_host_latency(config_.host_latency_s);
  identity_ = "FVB/1 valve controller";
}

void Valve::refuse(std::int32_t code, std::string text, Effects& fx, const Figure& figure) {
  fx.events.emplace_back(Result{Outcome::kRefused, -1, 0, 0, 0, code, std::move(text), figure});
}

void Valve::finish(Outcome outcome, std::int32_t code, std::string text, Effects& fx) {
  op_ = Op::kNone;
  ending_.clear();
  ending_code_ = kNoCode;
  fx.events.emplace_back(Result{outcome, -1, 0, 0, 0, code, std::move(text)});
}

void Valve::add_list(const ListName& name, double tick_s, double pulse_s, std::span<const std::int32_t> ticks,
                     std::int64_t now_us, Effects& fx) {
  if (!lists_.contains(name) && name > last_) {
    Kept kept;
    kept.refusal = broken_train_limit(config_, firmware_, tick_s, pulse_s, ticks);
    if (kept.refusal.empty()) {
      kept.ticks = std::make_shared<const std::vector<std::uint16_t>>(ticks.begin(), ticks.end());
      kept.tick_us = std::uint16_t(std::llround(tick_s * 1e6));
      kept.pulse_us = std::uint16_t(std::llround(pulse_s * 1e6));
    } else {
      fault(Severity::kWarning, kLimit, name_ + ": " + name.text() + " is refused: " + kept.refusal.text, fx,
            kept.refusal.figure);
    }
    lists_.emplace(name, std::move(kept));
  }
  pump(now_us, fx);
}

bool Valve::accept(std::initializer_list<Phase> phases, Effects& fx) {
  if (busy()) {
    refuse(kNoCode, name_ + " is busy with another command", fx);
    return false;
  }
  if (std::find(phases.begin(), phases.end(), phase_) == phases.end()) {
    refuse(kNoCode, name_ + " is " + standing(), fx);
    return false;
  }
  return true;
}

const Valve::Kept* Valve::usable(const ListName& name, Effects& fx) {
  const auto at = lists_.find(name);
  if (at == lists_.end()) {
    refuse(kNoCode,
           name.text() +
               (name <= last_ ? " was armed before and is never armed again" : " has not been received"),
           fx);
    return nullptr;
  }
  if (!at->second.refusal.empty()) {
    refuse(kLimit, name.text() + ": " + at->second.refusal.text, fx, at->second.refusal.figure);
    return nullptr;
  }
  return &at->second;
}

void Valve::load(const ListName& name, std::int64_t now_us, Effects& fx) {
  if (accept({Phase::kReady}, fx) && usable(name, fx)) {
    op_ = Op::kLoad;
    wanted_ = name;
    tries_ = 0;
    phase_ = Phase::kLoading;
  }
  pump(now_us, fx);
}

void Valve::arm(const ListName& name, std::int64_t now_us, Effects& fx) {
  if (accept({Phase::kReady}, fx)) {
    if (const Kept* kept = usable(name, fx)) {
      if (!holds(name)) {
        refuse(kNoCode, name.text() + " is not loaded", fx);
      } else {
        op_ = Op::kArm;
        phase_ = Phase::kArming;
        wanted_ = name;
        const auto last_us = std::int64_t(kept->ticks->back()) * kept->tick_us + kept->pulse_us;
        armed_ = Armed{name, id_, std::int64_t(kept->ticks->size()), last_us, 0, false, false};
        link_.push(fvb::number32(Type::kArm, seq(),
                                 std::uint32_t(std::llround(config_.dialect.arm_wait_s * 1e3)),
                                 Repeat::kNever));
        set_state(DeviceState::kStaged, "arming " + name.text(), fx);
      }
    }
  }
  pump(now_us, fx);
}

void Valve::disarm(std::int64_t now_us, Effects& fx) {
  if (accept({Phase::kReady, Phase::kArmed}, fx)) {
    if (!armed_) {
      refuse(kNoCode, name_ + " was not armed", fx);
    } else {
      op_ = Op::kDisarm;
      if (armed_->over) {
        tell_count(kNoCode, {}, fx);
      } else {
        phase_ = Phase::kEnding;
        give_up_us_ = 0;
        ask_status();
      }
    }
  }
  pump(now_us, fx);
}

// The answer of a disarm, and of an arm that was cut short.
void Valve::tell_count(std::int32_t code, std::string text, Effects& fx) {
  const Armed a = *armed_;
  const bool all = a.fired == a.entries;
  Result r{all           ? Outcome::kDone
           : a.fired > 0 ? Outcome::kFailed
                         : Outcome::kNone,
           a.fired,
           a.entries,
           0,
           0,
           code,
           std::move(text)};
  if (a.doubt && !all) {
    r.outcome = Outcome::kUnknown;
    r.unknown_from = a.fired;
    r.unknown_to = a.entries;
    r.code = kValveLost;
  }
  armed_.reset();
  op_ = Op::kNone;
  ending_.clear();
  ending_code_ = kNoCode;
  fx.events.emplace_back(std::move(r));
}

// The armed list has ended. If it may have fired its liquid is on the part: it is never armed again.
void Valve::end_list(bool doubt) {
  armed_->over = true;
  armed_->doubt = armed_->doubt || doubt;
  if (armed_->fired == 0 && !armed_->doubt) return;
  last_ = std::max(last_, armed_->name);
  lists_.erase(lists_.begin(), lists_.upper_bound(armed_->name));
}

void Valve::connected(std::int64_t, Effects& fx) {
  set_state(DeviceState::kIdentifying, identity_, fx);
  phase_ = Phase::kHello;
  seq_ = 0;
  link_.push(fvb::request(Type::kHello, seq(), {}, Repeat::kRead));
  link_.push(fvb::request(Type::kDisarm, seq(), {}, Repeat::kSetup));  // closed, whatever it was doing
  ask_status();
  link_.push(fvb::request(Type::kAbort, seq(), {}, Repeat::kSetup));
}

void Valve::close_valve(std::int64_t now_us, Effects& fx) {
  link_.clear_queue();
  if (held_ && !verified_) forget_list();  // its frames may have been thrown away with the queue
  link_.urgent(fvb::request(Type::kDisarm, seq(), {}, Repeat::kSetup), now_us, fx);
  ask_status();
  phase_ = Phase::kClosing;
}

void Valve::stop(std::int64_t now_us, Effects& fx) {
  if (phase_ == Phase::kDown || phase_ == Phase::kHello) return;  // a connection begins with DISARM
  if (busy() && ending_.empty()) ending_ = "safe stop";
  close_valve(now_us, fx);
}

void Valve::lost(std::int64_t, Effects& fx) {
  if (phase_ == Phase::kDown) return;
  const bool in_use = (armed_ && !armed_->over) || busy();
  phase_ = Phase::kDown;
  forget_list();
  if (!in_use) return;
  fault(Severity::kStop, kLinkLost, name_ + ": link lost while in use", fx);
  if (busy() && ending_.empty()) {
    ending_ = "the link was lost";
    ending_code_ = kLinkLost;
  }
}

// Only requests that a stop has overtaken come here; the status of the stop gives their result.
void Valve::failed(const Request&, std::int64_t, Effects&) {}

void Valve::forget_list() {
  held_.reset();
  dialect_.ticks = {};
  ticks_.reset();
  begun_ = verified_ = false;
  sent_ = 0;
}

// Interlock 3: the list is gone, and the number of its fired pulses is unknown. Found at the beginning of a
// connection it stops nothing: the loss of the one before has stopped all that ran.
void Valve::rebooted(std::int64_t now_us, Effects& fx) {
  if (armed_ && !armed_->over) end_list(true);
  fault(armed_ && phase_ != Phase::kHello ? Severity::kStop : Severity::kWarning, kValveLost,
        name_ + ": its controller was reset, the list is lost", fx);
  if (phase_ == Phase::kHello) return;
  if (busy() && ending_.empty()) {
    ending_ = "the controller was reset";
    ending_code_ = kValveLost;
  }
  set_state(DeviceState::kFault, "its controller was reset", fx);
  reconnect(now_us, fx, "its controller was reset");
}

// A controller that was disarmed at its panel, or that acknowledges ARM and does not arm, lets a path run
// dry.
void Valve::check_armed(const fvb::Status& s, Effects& fx) {
  if (phase_ != Phase::kArmed || armed_->told_disarmed) return;
  const bool armed = s.state == fvb::State::kArmed || s.state == fvb::State::kFiring;
  const bool all_fired = s.state == fvb::State::kDone && s.next >= armed_->entries;
  if (s.path == armed_->id && (armed || all_fired)) return;
  armed_->told_disarmed = true;
  fault(Severity::kStop, kInstrument,
        name_ + ": it is not armed any more: its state is " + std::string(fvb::name(s.state)) + " after " +
            std::to_string(s.next) + " of " + std::to_string(armed_->entries) + " pulses",
        fx);
}

void Valve::take_status(const fvb::Status& s, Effects& fx) {
  status_ = s;
  if (!armed_ || armed_->over) return;
  check_armed(s, fx);
  if (s.path != armed_->id) return;
  armed_->fired = std::min<std::int64_t>(s.next, armed_->entries);
  if (phase_ == Phase::kArmed && s.state == fvb::State::kFiring)
    set_state(DeviceState::kActive, "firing", fx);
}

void Valve::upload_refused(std::string_view why, bool again, Effects& fx) {
  if (!held_) return;
  const ListName which = *held_;
  const int tries = tries_;
  forget_list();
  if (again && tries < kMaxTries) {
    fault(Severity::kNotice, kCommandRejected, name_ + ": " + which.text() + " again: " + std::string(why),
          fx);
    tries_ = tries;
    return;
  }
  tries_ = 0;
  fault(Severity::kWarning, kCommandRejected,
        name_ + ": " + which.text() + " does not load: " + std::string(why), fx);
  lists_[which] = {nullptr, 0, 0, {"the controller does not take it: " + std::string(why)}};
  if (phase_ != Phase::kLoading || wanted_ != which) return;
  phase_ = Phase::kReady;
  finish(Outcome::kNone, kCommandRejected, std::string(why), fx);
}

void Valve::reply(const Request& request, std::span<const std::byte> frame, std::int64_t now_us,
                  Effects& fx) {
  const fvb::Found found = fvb::find(frame);
  const fvb::Reply r = *fvb::parse_reply(found);
  const bool first = boot_count_ < 0;
  const bool reset = !first && r.boot_count != boot_count_;
  boot_count_ = r.boot_count;
  if (reset) {
    rebooted(now_us, fx);
    if (phase_ == Phase::kDown) return;
  }
  const Type asked = Type(request.tag);
  if (r.type == Type::kNak) {
    const auto code = fvb::Refusal(r.refusal);
    const std::string why = "the controller refuses " + std::string(fvb::name(asked)) + ": " +
                            std::to_string(r.refusal) + " " + std::string(fvb::name(code));
    if (asked == Type::kBegin || asked == Type::kData || asked == Type::kEnd)
      return upload_refused(why, code != fvb::Refusal::kRange, fx);
    // In FAULT the firmware has closed the valve already; the status says whether it is so.
    if (asked == Type::kDisarm && code == fvb::Refusal::kWrongState && stopping()) return;
    fault(asked == Type::kDisarm ? Severity::kStop : Severity::kWarning, kCommandRejected, name_ + ": " + why,
          fx);
    if (asked == Type::kArm && op_ == Op::kArm) {
      ending_ = why;
      ending_code_ = kCommandRejected;
      return close_valve(now_us, fx);
    }
    return reconnect(now_us, fx, why);
  }
  switch (asked) {
    case Type::kHello:
      if (const auto h = fvb::parse_hello(found.payload)) {
        firmware_ = *h;
        identity_ = "FVB/1 valve controller, firmware " + std::to_string(h->firmware);
      }
      return;
    case Type::kBegin:
      begun_ = true;
      return;
    case Type::kEnd:
      if (held_ && begun_) {
        verified_ = true;
        tries_ = 0;
      }
      return;
    case Type::kStatus:
      if (const auto s = fvb::parse_status(found.payload)) take_status(*s, fx);
      return;
    default:
      return;
  }
}

// The list that a command waits for; else the next one, as soon as the controller is free.
bool Valve::choose_upload() {
  auto at = lists_.end();
  if (phase_ == Phase::kLoading) {
    at = lists_.find(wanted_);
  } else if (config_.upload_ahead && phase_ == Phase::kReady && !held_ && (!armed_ || armed_->over)) {
    at = lists_.upper_bound(last_);
    while (at != lists_.end() && !at->second.ticks) ++at;
  }
  if (at == lists_.end() || !at->second.ticks) return false;
  ++tries_;
  held_ = at->first;
  ticks_ = at->second.ticks;
  dialect_.ticks = *ticks_;
  begun_ = verified_ = false;
  sent_ = 0;
  id_ = ++last_id_;
  link_.push(fvb::begin(seq(), {id_, std::uint8_t(config_.valve), std::uint16_t(ticks_->size()),
                                at->second.tick_us, at->second.pulse_us}));
  return true;
}

bool Valve::upload_step() {
  if (phase_ == Phase::kLoading && held_ != wanted_) return choose_upload();
  if (!held_) return choose_upload();
  if (verified_ || !begun_) return false;
  if (sent_ < ticks_->size()) {
    const std::size_t n = std::min(fvb::kEntriesPerFrame, ticks_->size() - sent_);
    link_.push(fvb::data(seq(), sent_, n));
    sent_ += n;
  } else {
    link_.push(fvb::number16(Type::kEnd, seq(), fvb::list_crc(*ticks_)));
  }
  return true;
}

// DISARM is confirmed and the count read.
void Valve::closed_now(Effects& fx) {
  if (armed_) {
    if (!armed_->over) end_list(false);
    forget_list();  // it is used up, or is loaded again before it is armed
    if (status_.late_us > 1000)
      fault(Severity::kNotice, kInstrument,
            name_ + ": a pulse was " + std::to_string(status_.late_us) + " us late", fx,
            {double(status_.late_us), {}, "us"});
  }
  const Op op = op_;
  phase_ = Phase::kReady;
  set_state(DeviceState::kSafe, "closed", fx);
  if (op == Op::kDisarm || (op == Op::kArm && armed_))
    tell_count(ending_code_, ending_, fx);
  else if (op != Op::kNone)
    finish(Outcome::kNone, ending_code_, ending_, fx);
}

bool Valve::idle(std::int64_t now_us, Effects& fx) {
  switch (phase_) {
    case Phase::kDown:
      return false;
    case Phase::kHello:
      identified();
      [[fallthrough]];
    case Phase::kClosing:
      if (phase_ == Phase::kClosing &&
          (status_.state == fvb::State::kFiring || status_.state == fvb::State::kArmed)) {
        fault(Severity::kStop, kInstrument, name_ + ": it is not closed after DISARM", fx);
        link_.push(fvb::request(Type::kAbort, seq(), {}, Repeat::kSetup));
        ask_status();
        return true;
      }
      closed_now(fx);
      return true;
    case Phase::kLoading:
      if (!holds(wanted_)) return upload_step();
      phase_ = Phase::kReady;
      finish(Outcome::kDone, kNoCode, {}, fx);
      return true;
    case Phase::kArming:
      phase_ = Phase::kArmed;
      set_state(DeviceState::kArmed, armed_->name.text(), fx);
      finish(Outcome::kReady, kNoCode, {}, fx);
      return true;
    case Phase::kEnding: {
      // A clock that runs slow has pulses left when the path is over: they are awaited, within reason.
      const std::int64_t left_us = armed_->last_us - std::int64_t(status_.since_us) + 20'000;
      const bool firing = status_.state == fvb::State::kFiring && armed_->fired < armed_->entries;
      if (firing && give_up_us_ == 0 && left_us <= std::int64_t(config_.dialect.finish_s * 1e6)) {
        give_up_us_ = now_us + std::max<std::int64_t>(left_us, 1000);
        return true;
      }
      if (firing && now_us < give_up_us_) return false;
      link_.push(fvb::request(Type::kDisarm, seq(), {}, Repeat::kSetup));
      ask_status();
      phase_ = Phase::kClosing;
      return true;
    }
    case Phase::kReady:
      if (upload_step()) return true;
      [[fallthrough]];
    case Phase::kArmed: {
      const double period_s = phase_ == Phase::kArmed ? config_.poll_firing_s : config_.dialect.poll_idle_s;
      if (now_us - link_.last_sent_us() < std::int64_t(period_s * 1e6)) return false;
      ask_status();
      return true;
    }
  }
  return false;
}

std::int64_t Valve::device_wake_us() const {
  if (!link_.idle()) return 0;
  if (phase_ == Phase::kEnding) return give_up_us_;
  if (phase_ == Phase::kArmed) return link_.last_sent_us() + std::int64_t(config_.poll_firing_s * 1e6);
  if (phase_ == Phase::kReady) return link_.last_sent_us() + std::int64_t(config_.dialect.poll_idle_s * 1e6);
  return 0;
}

}  // namespace firn::drivers
