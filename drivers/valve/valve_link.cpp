// Valve: link, uploads, firing and counting.
#include <algorithm>

#include "drivers/valve/valve.h"

namespace firn::drivers {

using fvb::Type;

namespace {

constexpr int kMostTries = 3;

}  // namespace

// The armed list has ended. If it may have fired its liquid is on the part: it is never armed again.
void Valve::end_list(bool doubt) {
  armed_->over = true;
  armed_->doubt = armed_->doubt || doubt;
  if (armed_->fired == 0 && !armed_->doubt) return;
  last_ = std::max(last_, armed_->name);
  lists_.erase(lists_.begin(), lists_.upper_bound(armed_->name));
}

void Valve::connected(std::int64_t, Effects& fx) {
  set_state(DriverState::kIdentifying, identity_, fx);
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
  fault(2, kLinkLost, name_ + ": link lost while in use", fx);
  if (busy() && ending_.empty()) {
    ending_ = "the link was lost";
    ending_code_ = kLinkLost;
  }
}

// Only what a stop has overtaken comes here; the stop's own status says what became of it.
void Valve::failed(const Request&, std::int64_t, Effects&) {}

void Valve::forget_list() {
  held_.reset();
  dialect_.ticks = {};
  ticks_.reset();
  begun_ = verified_ = false;
  sent_ = 0;
}

// Interlock 3: the list is gone, and what it has fired nobody knows.
void Valve::rebooted(std::int64_t now_us, Effects& fx) {
  if (armed_ && !armed_->over) end_list(true);
  fault(armed_ ? 2 : 1, kValveLost, name_ + ": its controller was reset, the list is lost", fx);
  if (phase_ == Phase::kHello) return;
  if (busy() && ending_.empty()) {
    ending_ = "the controller was reset";
    ending_code_ = kValveLost;
  }
  set_state(DriverState::kFault, "its controller was reset", fx);
  reconnect(now_us, fx, "its controller was reset");
}

void Valve::take_status(const fvb::Status& s, Effects& fx) {
  status_ = s;
  if (!armed_ || armed_->over || s.path != armed_->id) return;
  armed_->fired = std::min<std::int64_t>(s.next, armed_->entries);
  if (phase_ == Phase::kArmed && s.state == fvb::State::kFiring)
    set_state(DriverState::kActive, "firing", fx);
}

void Valve::upload_refused(std::string_view why, bool again, Effects& fx) {
  if (!held_) return;
  const ListName which = *held_;
  const int tries = tries_;
  forget_list();
  if (again && tries < kMostTries) {
    fault(0, kCommandRejected, name_ + ": " + which.text() + " again: " + std::string(why), fx);
    tries_ = tries;
    return;
  }
  tries_ = 0;
  fault(1, kCommandRejected, name_ + ": " + which.text() + " does not load: " + std::string(why), fx);
  lists_[which] = {nullptr, 0, 0, "the controller does not take it: " + std::string(why)};
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
    fault(asked == Type::kDisarm ? 2 : 1, kCommandRejected, name_ + ": " + why, fx);
    if (asked == Type::kArm && op_ == Op::kArm) {
      ending_ = why;
      ending_code_ = kCommandRejected;
      return close_valve(now_us, fx);
    }
    return reconnect(now_us, fx, why);
  }
  switch (asked) {
    case Type::kHello:
      if (const auto h = fvb::parse_hello(found.payload))
        identity_ = "FVB/1 valve controller, firmware " + std::to_string(h->firmware);
      return;
    case Type::kBegin:
      begun_ = true;
      return;
    case Type::kEnd:
      if (held_ && begun_) verified_ = true, tries_ = 0;
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
      fault(0, kInstrument, name_ + ": a pulse was " + std::to_string(status_.late_us) + " us late", fx);
  }
  const Op op = op_;
  phase_ = Phase::kReady;
  set_state(DriverState::kSafe, "closed", fx);
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
        fault(2, kInstrument, name_ + ": it is not closed after DISARM", fx);
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
      set_state(DriverState::kArmed, armed_->name.text(), fx);
      finish(Outcome::kReady, kNoCode, {}, fx);
      return true;
    case Phase::kEnding: {
      // A clock that runs slow has pulses left when the path is over: they are awaited, within reason.
      const std::int64_t left_us = armed_->last_us - std::int64_t(status_.since_us) + 20'000;
      const bool firing = status_.state == fvb::State::kFiring && armed_->fired < armed_->entries;
      if (firing && give_up_us_ == 0 && left_us <= std::int64_t(config_.finish_s * 1e6)) {
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
      const double period_s = phase_ == Phase::kArmed ? config_.poll_firing_s : config_.poll_idle_s;
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
  if (phase_ == Phase::kReady) return link_.last_sent_us() + std::int64_t(config_.poll_idle_s * 1e6);
  return 0;
}

}  // namespace firn::drivers
