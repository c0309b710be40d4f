// Stage: link, stopping, the result of an interrupted operation, enabling and homing.
#include "drivers/stage/stage.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace firn::drivers {
namespace {

constexpr std::int64_t kStopLimit_us = 5'000'000;

std::string quoted_line(const Request& request) {
  std::string text(request.text());
  while (!text.empty() && (text.back() == '\n' || text.back() == '\r')) text.pop_back();
  return "'" + text + "'";
}

constexpr int kPollsToBegin = 3;
constexpr int kHomingOrder[] = {2, 0, 1};     // the nozzle goes up first
constexpr double kTriggerOffEarly_s = 0.002;  // at most between the trigger's off and the axis' ABORT

}  // namespace

using ensemble::Line;

void Stage::read(std::string_view verb, int axis, Tag tag) {
  link_.push(ensemble::question(config_.table, verb, axis, tag));
}

void Stage::setup(std::string_view verb, int axis, std::string_view rest, Tag tag) {
  link_.push(ensemble::setting(config_.table, verb, axis, rest, tag));
}

void Stage::connected(std::int64_t now_us, Effects& fx) {
  set_state(DeviceState::kIdentifying, identity_, fx);
  outputs_.forget(config_.table.increments());
  absolute_ = initialised_ = false;
  initialise_after_stop_ = true;
  doom_.reset();
  link_.push(Line(config_.table, Repeat::kSetup, kPlain).text("WAIT MODE NOWAIT"));
  send_stop_burst(now_us, fx, false);  // whatever it was doing; an operation in doubt is judged afterwards
  phase_ = Phase::kStopping;
  poll_ = Poll::kNone;
  poll_at_us_ = now_us;
  move_limit_us_ = now_us + kStopLimit_us;
}

void Stage::send_stop_burst(std::int64_t now_us, Effects& fx, bool urgently) {
  // Trigger off before the deceleration begins, so that nothing fires at a changing speed.
  triggers_off_us_ = 0;
  const auto send = [&](std::string_view verb, int axis, std::string_view rest, Tag tag = kHarmless) {
    const Request r = ensemble::setting(config_.table, verb, axis, rest, tag);
    if (urgently) link_.urgent(r, now_us, fx);
    if (!urgently || link_.suspect()) link_.push(r);  // on a suspect link nobody hears the first answer
  };
  for (const int axis : {0, 1}) send("PSOCONTROL @", axis, " OFF", kTriggerOff);
  if (op_ == Op::kTrace) send(config_.dialect.stop_path_program, 0, "");
  if (config_.homing == Homing::kProgram && (phase_ == Phase::kHoming || phase_ == Phase::kDown))
    send(config_.table.stop_program, 0, "");
  for (const int axis : {0, 1, 2}) send("ABORT @", axis, "");
}

void Stage::begin_stop(std::int64_t now_us, Effects& fx, std::string why, std::int32_t code) {
  if (stopping()) return;
  if (ending_.empty()) {
    ending_ = std::move(why);
    ending_code_ = code;
  }
  link_.clear_queue();
  send_stop_burst(now_us, fx, true);
  absolute_ = false;
  phase_ = Phase::kStopping;
  poll_ = Poll::kNone;
  poll_at_us_ = now_us;
  move_limit_us_ = now_us + kStopLimit_us;
}

void Stage::stop(std::int64_t now_us, Effects& fx) {
  if (!link_.is_open() || phase_ == Phase::kDown) return;  // the next connection begins with a stop
  if (phase_ == Phase::kDead) return send_stop_burst(now_us, fx, true);
  initialise_after_stop_ = false;  // no homing after a stop: the next command begins with it
  begin_stop(now_us, fx, "safe stop", kNoCode);
}

void Stage::lost(std::int64_t, Effects& fx) {
  if (phase_ == Phase::kDown) return;
  phase_ = Phase::kDown;
  if (!busy()) return;
  if (ending_.empty()) {
    ending_ = "the link was lost";
    ending_code_ = kLinkLost;
  }
  fault(Severity::kStop, kLinkLost, "stage: link lost during a command", fx);
}

void Stage::failed(const Request& request, std::int64_t now_us, Effects& fx) {
  const std::string why = "no good reply to " + quoted_line(request) + not_understood();
  fault(Severity::kWarning, kLinkLost, "stage: " + why, fx);
  const bool working = phase_ == Phase::kToStart || phase_ == Phase::kAtStart || phase_ == Phase::kArming ||
                       phase_ == Phase::kSettling || phase_ == Phase::kFiring || phase_ == Phase::kCounting ||
                       phase_ == Phase::kHoming;
  if (stopping() && request.repeat == Repeat::kNever) return;  // of the operation that is being stopped
  if (working) return begin_stop(now_us, fx, why, kLinkLost);
  reconnect(now_us, fx, why);
}

void Stage::rejected(const Request& request, const ensemble::Reply& reply, std::int64_t now_us, Effects& fx) {
  using Kind = ensemble::Reply::Kind;
  if (request.tag == kCount) {  // this controller has no such counter: the pulses stay in doubt
    fault(Severity::kWarning, kInstrument, "stage: the controller does not answer " + quoted_line(request),
          fx);
    pulses_.reset();
    return;
  }
  if (request.tag == kSamples || request.tag == kSample) {
    fault(Severity::kWarning, kInstrument,
          "stage: the followed path is not recorded: the controller does not answer " + quoted_line(request),
          fx);
    readout_.refused();
    return;
  }
  if (request.tag == kTask) return;  // it does not tell: the time of the homing is its limit
  const char* how = reply.kind == Kind::kNak     ? "does not understand "
                    : reply.kind == Kind::kFault ? "cannot do "
                                                 : "timed out at ";
  std::string why = std::string("the controller ") + how + quoted_line(request);
  if (request.tag == kHarmless ||
      request.tag == kTriggerOff) {  // an axis that is not enabled may refuse ABORT
    fault(Severity::kNotice, kCommandRejected, "stage: " + why, fx);
    return;
  }
  doom_ = doom_                    ? doom_
          : phase_ < Phase::kReady ? std::optional<Doom>({DeviceState::kFault, kCommandRejected, why})
                                   : std::nullopt;
  if (stopping()) {
    fault(Severity::kWarning, kCommandRejected, "stage: " + why, fx);
    return reconnect(now_us, fx, why);
  }
  begin_stop(now_us, fx, why, kCommandRejected);
}

void Stage::check_status(int axis, std::uint32_t bits, std::int64_t now_us, Effects& fx) {
  status_[std::size_t(axis)] = bits;
  if (was_homed_ && !(bits & ensemble::kHomed)) restarted_ = true;
  if (bits & ensemble::kEstopInput) {
    if (!doom_) doom_ = Doom{DeviceState::kEstop, kEstop, "emergency stop"};
    if (phase_ != Phase::kDead) begin_stop(now_us, fx, "emergency stop", kEstop);
    return;
  }
  const bool expected_on = phase_ == Phase::kReady || phase_ == Phase::kToStart || phase_ == Phase::kFiring;
  if (expected_on && initialised_ && !(bits & ensemble::kEnabled)) {
    const std::string why = std::string("axis ") + kAxisNames[axis] + " has disabled itself";
    doom_ = Doom{DeviceState::kFault, kAxisFault, why};
    begin_stop(now_us, fx, why, kAxisFault);
  }
}

void Stage::reply(const Request& request, std::span<const std::byte> frame, std::int64_t now_us,
                  Effects& fx) {
  const ensemble::Reply r = dialect_.parse(frame);
  if (r.kind != ensemble::Reply::Kind::kOk) return rejected(request, r, now_us, fx);
  const auto axis = std::size_t(request.argument);  // or the number of the increment, of the sample
  switch (request.tag) {
    case kStatus:
      if (const auto bits = r.bits()) check_status(request.argument, *bits, now_us, fx);
      break;
    case kTriggerOff:  // of both axes, the one that pulses first: one that refused it may go on
      if (request.argument == 0 || triggers_off_us_ > 0) triggers_off_us_ = now_us;
      break;
    case kPlane:
      plane_busy_ = r.bits().value_or(1u) != 0;
      break;
    case kPosition:
      position_mm_[axis] = r.number().value_or(std::numeric_limits<double>::quiet_NaN());
      break;
    case kCount:
      if (const auto n = r.number()) pulses_ = std::int64_t(*n);
      break;
    case kTask:
      if (r.number() == double(ensemble::kTaskError) && phase_ == Phase::kHoming)
        give_up(DeviceState::kFault, kStall,
                std::string("axis ") + kAxisNames[axis] + ": the homing program has ended with an error",
                now_us, fx);
      break;
    case kSamples:
      if (const auto n = r.number()) readout_.held(*n);
      break;
    case kSample:
      if (const auto mm = r.number()) readout_.take(request.argument, *mm);
      break;
    case kFaultBits:
      fault_bits_[axis] = r.bits().value_or(~0u);
      break;
    case kParameter:
      parameters_.take(request.argument, r.number().value_or(std::numeric_limits<double>::quiet_NaN()));
      break;
    case kIncrement:
      outputs_.acknowledged(axis);
      break;
    default:
      break;
  }
}

void Stage::evidence_complete(std::int64_t now_us, Effects& fx) {
  for (std::size_t a = 0; a < 3 && !initialise_after_stop_; ++a)
    if (fault_bits_[a] != 0) {
      const bool estop = fault_bits_[a] & 1u << 11;
      const std::int32_t code = estop                                        ? kEstop
                                : fault_bits_[a] & ensemble::kFollowingError ? kStall
                                                                             : kAxisFault;
      const std::string why =
          std::string("axis ") + kAxisNames[a] + ": " + ensemble::fault_names(fault_bits_[a]);
      if (!doom_ || doom_->code == kAxisFault)
        doom_ = Doom{estop ? DeviceState::kEstop : DeviceState::kFault, code, why};
      ending_ += (ending_.empty() ? "" : "; ") + why;
    }
  conclude(now_us, fx);
  if (doom_) {
    phase_ = Phase::kDead;
    initialised_ = false;
    set_state(doom_->state, doom_->text, fx);
    fault(Severity::kStop, doom_->code, "stage: " + doom_->text, fx);
    doom_.reset();
  } else if (initialise_after_stop_) {
    phase_ = Phase::kFaultCheck;
    axis_ = 0;
    asked_ = acknowledged_ = false;
  } else {
    phase_ = Phase::kReady;
    set_state(DeviceState::kSafe, ending_.empty() ? "stopped" : ending_, fx);
  }
  initialise_after_stop_ = false;
}

// Pulses that the running row can have fired, by the place where its axis came to rest; nothing where no
// place on the row was read.
std::optional<PulseRange> Stage::pulses_possible() const {
  const RasterRun& run = runs_[progress_.run];
  const double slack_mm = 2.0 * config_.dialect.tolerance_mm +
                          double(config_.dialect.pulse_tolerance_counts) / config_.counts_per_mm;
  if (!(std::abs(position_mm_[1] - run.y_mm) <= slack_mm) || std::isnan(position_mm_[0])) return std::nullopt;
  const double brake_mm = speed_mm_s_ * speed_mm_s_ / (2.0 * config_.acceleration_mm_s2);
  const double late_mm = speed_mm_s_ * (kTriggerOffEarly_s + 2.0 * config_.host_latency_s);
  return pulses_by_place(run, position_mm_[0], brake_mm + late_mm, slack_mm, config_.counts_per_mm);
}

// Result of the operation from the pulse counter: rows before this one are counted; the pulses of this
// one are a prefix of it. Without a counter that can be trusted they are in doubt: one that restarted, or one
// that does not fit the place where the axis stands.
void Stage::conclude(std::int64_t now_us, Effects& fx) {
  if (!busy()) return;
  Result r;
  r.until_us = triggers_off_us_ ? triggers_off_us_ : now_us;
  r.expected = expected_;
  r.code = ending_code_;
  r.text = ending_;
  r.outcome = progress_.launched ? Outcome::kFailed : Outcome::kNone;
  const bool counter_is_ours = pulses_ && *pulses_ >= 0 && !restarted_;
  if (op_ == Op::kPass) {
    const auto n = std::int64_t(runs_[progress_.run].increments.size());
    r.counted = r.unknown_from = r.unknown_to = progress_.before;
    const std::optional<PulseRange> possible = progress_.launched ? pulses_possible() : std::nullopt;
    if (progress_.launched && counter_is_ours && *pulses_ > n) {
      r.code = kPulseCount;
      r.text += "; " + std::to_string(*pulses_ - n) + " more pulses than commanded";
      r.unknown_from = r.unknown_to = r.counted += n;
    } else if (progress_.launched && counter_is_ours && possible && possible->contains(*pulses_)) {
      if (*pulses_ == n && r.counted + n == expected_) r.outcome = Outcome::kDone;
      r.unknown_from = r.unknown_to = r.counted += *pulses_;
    } else if (progress_.launched && counter_is_ours && possible) {
      r.outcome = Outcome::kUnknown;
      r.code = kPulseCount;
      r.text += "; " + std::to_string(*pulses_) + " pulses counted where the place of the axis says " +
                std::to_string(possible->least) + " to " + std::to_string(possible->most);
      r.unknown_from += std::min(*pulses_, possible->least);
      r.unknown_to += std::max(*pulses_, possible->most);
    } else if (progress_.launched) {
      r.outcome = Outcome::kUnknown;
      r.unknown_to += n;
    }
    if (r.outcome != Outcome::kUnknown && r.outcome != Outcome::kDone)
      r.outcome = r.counted == 0 && r.code != kPulseCount ? Outcome::kNone : Outcome::kFailed;
  } else if (op_ == Op::kTrace) {
    r.counted = !progress_.launched ? 0 : counter_is_ours ? *pulses_ : -1;
    if (progress_.launched) {  // material lies on a part of the way: the next map says where
      r.outcome = Outcome::kUnknown;
      r.unknown_to = expected_;
    }
  } else if (op_ == Op::kScan) {
    r.counted = !progress_.launched ? 0 : counter_is_ours ? *pulses_ : -1;
  }
  finish(std::move(r), fx);
}

void Stage::finish(Result result, Effects& fx) {
  if (op_ == Op::kTrace && progress_.launched && config_.path_sample_s > 0.0)
    fx.measured<Stage>(readout_.take_followed());
  op_ = Op::kNone;
  runs_.clear();
  way_ = {};
  fx.events.emplace_back(std::move(result));
}

bool Stage::idle(std::int64_t now_us, Effects& fx) {
  switch (phase_) {
    case Phase::kDown:
      return false;
    case Phase::kStopping:
    case Phase::kToStart:
    case Phase::kAtStart:
    case Phase::kArming:
    case Phase::kSettling:
    case Phase::kFiring:
    case Phase::kCounting:
      return work(now_us, fx);
    case Phase::kEvidence:
      evidence_complete(now_us, fx);
      return true;
    case Phase::kReady:
    case Phase::kDead:
      if (now_us - link_.last_sent_us() < std::int64_t(config_.poll_idle_s * 1e6)) return false;
      read("AXISSTATUS(@)", axis_ = (axis_ + 1) % 3, kStatus);
      return true;
    default:
      return initialise(now_us, fx);
  }
}

std::int64_t Stage::device_wake_us() const {
  if (!link_.idle()) return 0;
  if (phase_ == Phase::kReady || phase_ == Phase::kDead)
    return link_.last_sent_us() + std::int64_t(config_.poll_idle_s * 1e6);
  if (phase_ == Phase::kToStart || phase_ == Phase::kSettling || phase_ == Phase::kFiring ||
      phase_ == Phase::kStopping || phase_ == Phase::kHoming)
    return poll_at_us_;
  return 0;
}

// Fault check, FAULTACK, ENABLE, homing, ramps. @returns true if something was queued.
bool Stage::initialise(std::int64_t now_us, Effects& fx) {
  switch (phase_) {
    case Phase::kFaultCheck:
      if (axis_ == 3) {
        for (int a = 0; a < 3; ++a) setup("ENABLE @", a, "");
        for (int a = 0; a < 3; ++a) read("AXISSTATUS(@)", a, kStatus);
        phase_ = Phase::kEnabling;
        return true;
      }
      if (!asked_) {
        read("AXISFAULT(@)", axis_, kFaultBits);
        return asked_ = true;
      }
      if (fault_bits_[std::size_t(axis_)] == 0) {
        ++axis_;
        asked_ = acknowledged_ = false;
        return initialise(now_us, fx);
      }
      if (!acknowledged_) {
        fault(Severity::kNotice, kAxisFault,
              std::string("stage: axis ") + kAxisNames[axis_] +
                  " had a fault: " + ensemble::fault_names(fault_bits_[std::size_t(axis_)]),
              fx);
        setup("FAULTACK @", axis_, "");
        read("AXISFAULT(@)", axis_, kFaultBits);
        return acknowledged_ = true;
      }
      begin_stop(now_us, fx, "the fault of an axis stays", kAxisFault);
      return true;
    case Phase::kEnabling:
      for (std::size_t a = 0; a < 3; ++a)
        if (!(status_[a] & ensemble::kEnabled))
          return give_up(DeviceState::kFault, kAxisFault,
                         std::string("axis ") + kAxisNames[a] + " does not enable", now_us, fx);
      phase_ = Phase::kParameters;
      asked_ = false;
      return check_parameters(now_us, fx);
    case Phase::kParameters:
      return check_parameters(now_us, fx);
    case Phase::kHoming:
      return home_next(now_us, fx);
    case Phase::kRamp:
      if (!asked_) {
        for (int a = 0; a < 3; ++a) setup("RAMP MODE @", a, " RATE");
        link_.push(Line(config_.table, Repeat::kSetup, kPlain)
                       .text("RAMP RATE ")
                       .fixed4(config_.acceleration_mm_s2));
        if (on(config_.linear_ramps))
          link_.push(Line(config_.table, Repeat::kSetup, kPlain).text("SCURVE 0"));
        for (int a = 0; a < 3; ++a) read("PFBKPROG(@)", a, kPosition);
        return asked_ = true;
      }
      identified();
      restarted_ = false;
      was_homed_ = initialised_ = (status_[0] & status_[1] & status_[2] & ensemble::kHomed) != 0;
      progress_ = {};
      if (busy() && op_ != Op::kHome && initialised_) {
        go_to_start(now_us);
        return true;
      }
      phase_ = Phase::kReady;
      set_state(DeviceState::kSafe, initialised_ ? "homed" : "not homed", fx);
      if (op_ == Op::kHome)
        finish({Outcome::kDone, -1, 0, 0, 0, kNoCode, "homed"}, fx);
      else if (busy())
        finish({Outcome::kRefused, -1, expected_, 0, 0, kLimit, "the stage is not homed"}, fx);
      return false;
    default:
      return false;
  }
}

// The stop of an initialisation that cannot go on.
bool Stage::give_up(DeviceState state, std::int32_t code, std::string why, std::int64_t now_us, Effects& fx) {
  doom_ = Doom{state, code, why};
  begin_stop(now_us, fx, std::move(why), code);
  return true;
}

bool Stage::check_parameters(std::int64_t now_us, Effects& fx) {
  if (on(config_.check_parameters) && !asked_) {
    ControllerParameters::ask(config_.table, link_);
    return asked_ = true;
  }
  if (on(config_.check_parameters)) {
    if (const auto why = parameters_.mismatch(config_, limits_))
      return give_up(DeviceState::kFault, kLimit, *why, now_us, fx);
    config_.table.iglobals = parameters_.global_integers();
    outputs_.resize(config_.table.increments());
  }
  phase_ = Phase::kHoming;
  axis_ = 0;
  asked_ = false;
  return home_next(now_us, fx);
}

void Stage::start_homing(int axis, std::int64_t now_us) {
  poll_at_us_ = now_us;
  home_polls_ = 0;
  move_limit_us_ = now_us + std::int64_t(config_.home_timeout_s * 1e6);
  asked_ = true;
  progress_.launched = true;
  if (config_.homing == Homing::kCommand) {
    Line line(config_.table, Repeat::kNever, kMotion);
    link_.push(with_axis(line, config_.table.home, axis));
    read("AXISSTATUS(@)", axis, kStatus);
    return;
  }
  const auto set = [&](int iglobal, int value) {
    Line line(config_.table, Repeat::kSetup, kPlain);
    link_.push(line.text("IGLOBAL(").integer(iglobal).text(")=").integer(value));
  };
  set(config_.table.home_count_iglobal, 1);
  set(config_.table.home_axis_iglobal, axis);
  link_.push(Line(config_.table, Repeat::kNever, kMotion).text(config_.table.home_program));
  // The program begins a little later: a home flag that was read before it says nothing.
  status_[std::size_t(axis)] &= ~std::uint32_t(ensemble::kHomed);
  poll_at_us_ += std::int64_t(config_.poll_moving_s * 1e6);
}

// One axis after the other, Z first. Homing is begun once and then only watched.
bool Stage::home_next(std::int64_t now_us, Effects& fx) {
  for (; axis_ < 3; ++axis_, asked_ = false) {
    const int axis = kHomingOrder[axis_];
    const std::uint32_t bits = status_[std::size_t(axis)];
    if (!asked_) {
      const bool homed = bits & ensemble::kHomed;
      if (op_ == Op::kHome ? false : homed || !on(config_.home_at_start)) continue;
      start_homing(axis, now_us);
      return true;
    }
    if (bits & ensemble::kHomed && !(bits & (ensemble::kMoving | ensemble::kHoming))) continue;
    if (now_us >= move_limit_us_)
      return give_up(DeviceState::kFault, kStall,
                     std::string("axis ") + kAxisNames[axis] + " is not home in time", now_us, fx);
    if (now_us < poll_at_us_) return false;
    poll_at_us_ = now_us + std::int64_t(config_.poll_moving_s * 1e6);
    read("AXISSTATUS(@)", axis, kStatus);
    // An axis that stands although the program has had time to begin: the program may be over.
    const bool stands = !(bits & (ensemble::kMoving | ensemble::kHoming));
    const std::string task = ensemble::task_question(config_.table.home_program);
    if (config_.homing == Homing::kProgram && ++home_polls_ > kPollsToBegin && stands && !task.empty())
      read(task, axis, kTask);
    return true;
  }
  phase_ = Phase::kRamp;
  asked_ = false;
  return initialise(now_us, fx);
}

}  // namespace firn::drivers
