// Robot: link, stopping, the result of an interrupted command, and the orders of a person.
#include "drivers/robot/robot.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

namespace firn::drivers {
namespace {

constexpr std::int64_t kStopLimit_us = 5'000'000, kStopPoll_us = 50'000;
constexpr int kWatchdog = int(fvp::Nak::kWatchdog);

std::string quoted_verb(const Request& request) {
  if (request.format == fvp::kBlock) return "'PATH P'";
  std::string_view text = fvp::parse(request.text()).text;
  return "'" + std::string(text) + "'";
}

constexpr double kRadians = std::numbers::pi / 180.0;
constexpr double kJog = 5.0;  // deg, or mm of J3
constexpr int kJogPercent = 1, kMaxLines = 1000;

std::string_view reply_text(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace

void Robot::connected(std::int64_t now_us, Effects& fx) {
  set_state(DeviceState::kIdentifying, identity_, fx);
  phase_ = Phase::kHello;
  doom_.reset();
  where_.reset();
  commanded_.reset();
  seq_ = 0;  // HELLO begins the count anew
  ask("HELLO FIRN 1", kHello);
  ask("STAT", kStat);
  step_ = 0;
  limit_us_ = now_us + kStopLimit_us;
}

void Robot::begin_stop(std::int64_t now_us, Effects& fx, std::string why, std::int32_t code) {
  if (stopping()) return;
  if (busy() && ending_.empty()) {
    ending_ = std::move(why);
    ending_code_ = code;
  }
  link_.clear_queue();
  // Flow and trigger off before the deceleration begins.
  for (const char* verb : {"SIG 0", "STOP"}) {
    LineWriter line = fvp::request(seq(), verb);
    link_.urgent(fvp::to_request(line, seq_, Repeat::kSetup, kHarmless), now_us, fx);
  }
  phase_ = Phase::kStopping;
  step_ = 0;
  poll_at_us_ = now_us;
  limit_us_ = now_us + kStopLimit_us;
  move_over_ = false;
  commanded_.reset();
  paths_.abandon();  // its requests may have been thrown away with the queue
}

void Robot::stop(std::int64_t now_us, Effects& fx) {
  if (!link_.is_open() || phase_ == Phase::kDown || phase_ == Phase::kHello) return;  // it begins with a stop
  if (phase_ == Phase::kDead) {
    LineWriter line = fvp::request(seq(), "STOP");
    return link_.urgent(fvp::to_request(line, seq_, Repeat::kSetup, kHarmless), now_us, fx);
  }
  begin_stop(now_us, fx, "safe stop", kNoCode);
}

void Robot::lost(std::int64_t, Effects& fx) {
  if (phase_ == Phase::kDown) return;
  phase_ = Phase::kDown;
  paths_.forget_slots();
  if (!busy()) return;
  if (ending_.empty()) {
    ending_ = "the link was lost";
    ending_code_ = kLinkLost;
  }
  fault(Severity::kStop, kLinkLost, "robot: link lost during a command", fx);
}

// Only requests that a stop has overtaken come here: the evidence of the stop gives their result.
void Robot::failed(const Request& request, std::int64_t, Effects& fx) {
  if (request.tag != kHarmless && request.tag != kBeat && request.tag != kStat)
    fault(Severity::kNotice, kLinkLost, "robot: no reply to " + quoted_verb(request), fx);
}

void Robot::refused(const Request& request, int code, std::string_view text, std::int64_t now_us,
                    Effects& fx) {
  const std::string why =
      "the robot refuses " + quoted_verb(request) + ": " + std::to_string(code) + " " + std::string(text);
  switch (request.tag) {
    case kHarmless:
    case kDropSlot:
      return fault(Severity::kNotice, kCommandRejected, "robot: " + why, fx);
    case kClear:  // it is still braking: asked again
      step_ = 0;
      poll_at_us_ = now_us + kStopPoll_us;
      return;
    case kBegin:
    case kPoints:
    case kEnd:
      return upload_refused(why, fx);
    case kRunPath:
      launched_ = false;  // it did not start
      break;
    default:
      break;
  }
  if (phase_ == Phase::kHello || phase_ == Phase::kStopping) {
    fault(Severity::kWarning, kCommandRejected, "robot: " + why, fx);
    if (request.tag == kMove) {  // it cannot raise: the stop is complete all the same
      move_over_ = true;
      return;
    }
    return reconnect(now_us, fx, why);
  }
  begin_stop(now_us, fx, why, code == int(fvp::Nak::kMonitorSpeed) ? kTimeSlip : kCommandRejected);
}

// Errors that last until the operator's reset. The watchdog is not one of them: it shows as a lost link, and
// is cleared when the robot is heard again.
std::optional<Robot::Doom> Robot::latched() const {
  if (status_.state == fvp::State::kEstop) return Doom{DeviceState::kEstop, kEstop, "emergency stop"};
  if (status_.state != fvp::State::kFault || status_.error == kWatchdog) return std::nullopt;
  return Doom{DeviceState::kFault, kAxisFault,
              "motion error " + std::to_string(status_.error) + ", STATE(1) = " +
                  std::to_string(status_.state1) + ", STATE(2) = " + std::to_string(status_.state2)};
}

void Robot::take_status(const fvp::Status& s, std::int64_t now_us, Effects& fx) {
  if (boot_count_ >= 0 && s.boot_count != boot_count_) {
    restarted_ = true;
    where_.reset();
    commanded_.reset();
    paths_.forget_slots();
    if (phase_ != Phase::kHello)
      fault(Severity::kWarning, kInstrument, "robot: its program was started anew", fx);
  }
  boot_count_ = s.boot_count;
  status_ = s;
  const bool stopped = s.state == fvp::State::kEstop || s.state == fvp::State::kFault;
  if (stopped && !reset_permitted_ && phase_ != Phase::kHoming && phase_ != Phase::kDead && !doom_) {
    doom_ = latched();
    begin_stop(now_us, fx, doom_ ? doom_->text : "its watchdog stopped it", doom_ ? doom_->code : kLinkLost);
  } else if (restarted_ && !stopping() && phase_ != Phase::kDead) {
    begin_stop(now_us, fx, "its program was started anew", kInstrument);
  }
  if (launched_ && s.last == run_id_ && s.running != run_id_ && !restarted_) {
    if (s.last_done) {
      path_over_ = true;
      took_ms_ = s.last_ms;
    } else if (!stopping()) {
      begin_stop(now_us, fx, "the robot has stopped the path", kAxisFault);
    }
  }
}

void Robot::reply(const Request& request, std::span<const std::byte> frame, std::int64_t now_us,
                  Effects& fx) {
  WordReader words(fvp::parse(text_of(frame)).text);
  const bool good = words.word() == "ACK";
  if (!good) {
    const auto code = int(words.number(0, 9999));
    return refused(request, code, words.rest().substr(words.rest().empty() ? 0 : 1), now_us, fx);
  }
  switch (request.tag) {
    case kHello:
      identity_ = "Adept Cobra 600, " + std::string(words.rest().substr(words.rest().empty() ? 0 : 1));
      return;
    case kStat:
      if (const auto s = fvp::parse_status(words)) return take_status(*s, now_us, fx);
      return reconnect(now_us, fx, "a status that is none");
    case kWhere:
      if (const auto c = fvp::parse_counts(words); c && words.at_end())
        where_ = *c;
      else
        reconnect(now_us, fx, "joints that are none");
      return;
    case kBeat:
      if (phase_ == Phase::kRunning && words.word() != fvp::name(fvp::State::kRunning)) poll_at_us_ = now_us;
      return;
    case kSpeed:
      status_.speed_percent = int(words.number(0, 999));
      return;
    case kMove:
      if (!move_over_) where_.reset();  // until it has arrived
      return;
    case kBegin:
    case kPoints:
    case kEnd:
      if (const auto why = paths_.acknowledged(request.tag, words.number(0, fvp::kMaxId)); !why.empty())
        upload_refused(why, fx);
      return;
    case kRunPath:
      if (phase_ != Phase::kStarting) return;  // a stop came between
      phase_ = Phase::kRunning;
      poll_at_us_ = now_us + planned_us() + 100'000 + std::int64_t(config_.host_latency_s * 1e6);
      limit_us_ = now_us + std::int64_t(double(planned_us()) * config_.stall_factor +
                                        (config_.stall_s + 2.0 * config_.host_latency_s) * 1e6);
      return;
    default:
      return;
  }
}

void Robot::unsolicited(std::span<const std::byte> frame, std::int64_t now_us, Effects& fx) {
  WordReader words(fvp::parse(text_of(frame)).text);
  const std::string_view kind = words.word();
  if (kind == "PATH_DONE") {
    const auto id = std::int32_t(words.number(1, fvp::kMaxId));
    const auto ms = std::int32_t(words.number(0, 9'999'999));
    const auto where = fvp::parse_counts(words);
    if (!where || !launched_ || id != run_id_) return;
    where_ = *where;
    path_over_ = true;
    took_ms_ = ms;
  } else if (kind == "MOVE_DONE") {
    const auto where = fvp::parse_counts(words);
    if (!where) return;
    where_ = *where;
    move_over_ = true;
  } else if (kind == "MOTION_ERR" && !stopping() && phase_ != Phase::kDead) {
    begin_stop(now_us, fx, "motion error " + std::string(words.rest()), kAxisFault);
  }
}

// Step 0 asks until nothing moves, 1 clears and reads the state, 2 reports the result of the command, 3
// raises.
bool Robot::stopping_step(std::int64_t now_us, Effects& fx) {
  switch (step_) {
    case 0:
      if (now_us < poll_at_us_) return false;
      ask("STAT", kStat);
      step_ = 1;
      return true;
    case 1:
      if (status_.state == fvp::State::kRunning || status_.state == fvp::State::kBoot) {
        if (now_us >= limit_us_) {
          fault(Severity::kStop, kStall, "robot: it does not stop", fx);
          reconnect(now_us, fx, "it does not stop");
          return true;
        }
        poll_at_us_ = now_us + kStopPoll_us;
        step_ = 0;
        return true;
      }
      if (reset_permitted_ && latched() &&
          now_us >= limit_us_) {  // refused until now: not because it is still braking
        reset_permitted_ = false;
        doom_ = latched();
        doom_->text = doom_->state == DeviceState::kEstop ? "the emergency stop is still pressed"
                                                          : "the fault cannot be cleared";
      }
      if (latched()) low_ = false;  // after a failure the arm is not raised by itself: homing does that
      if (!doom_ && (status_.state == fvp::State::kHold || status_.state == fvp::State::kFault ||
                     status_.state == fvp::State::kEstop))
        order("CLEAR", kClear);
      for (const std::int32_t id : status_.held)
        if (id != 0 && !paths_.in_slot(id))
          push(fvp::request(seq(), "PATH DROP").word(id), Repeat::kSetup, kDropSlot);
      ask("STAT", kStat);
      ask("STAT J", kWhere);
      step_ = 2;
      return true;
    case 2: {
      reset_permitted_ = false;
      if (!doom_) doom_ = latched();
      conclude(fx);
      if (doom_) {
        die(fx);
        return true;
      }
      const double high = config_.limits[2].high;
      if (low_ && config_.raise_on_stop_mm > 0.0 && status_.power && status_.calibrated && where_) {
        const double z = fvp::joints_of(*where_)[2];
        Target up{true, *where_, approach_percent_};
        up.counts[2] = fvp::counts_of({0.0, 0.0, std::min(z + config_.raise_on_stop_mm, high), 0.0})[2];
        start_move(up, now_us);
        step_ = 3;
        return true;
      }
      ready("stopped", fx);
      return true;
    }
    default: {
      const Motion m = motion(now_us);
      if (m == Motion::kOver) {
        low_ = false;
        ready("stopped", fx);
      } else if (m == Motion::kWaiting && now_us >= limit_us_) {
        fault(Severity::kStop, kStall, "robot: it does not raise the tool in time", fx);
        low_ = false;  // once is enough
        reconnect(now_us, fx, "it does not raise the tool");
      }
      return m != Motion::kWaiting;
    }
  }
}

void Robot::ready(std::string_view text, Effects& fx) {
  phase_ = Phase::kReady;
  restarted_ = false;
  identified();
  set_state(DeviceState::kSafe, text, fx);
}

void Robot::die(Effects& fx) {
  phase_ = Phase::kDead;
  restarted_ = false;
  set_state(doom_->state, doom_->text, fx);
  fault(Severity::kStop, doom_->code, "robot: " + doom_->text, fx);
  doom_.reset();
}

// Result of the command from the robot's own status: the path it started last and its progress.
// Without that (it was started anew) a path that was launched is in doubt.
void Robot::conclude(Effects& fx) {
  if (!busy()) return;
  Result r;
  r.code = ending_code_;
  r.text = ending_;
  r.outcome = Outcome::kNone;
  if (op_ == Op::kRun) {
    r.expected = planned_us();
    r.counted = 0;
    const bool passed_on = launched_ && !restarted_;
    if (passed_on && path_over_) {
      complete_run(fx);
      commanded_.reset();  // it is raised next
      return;
    }
    if (passed_on && status_.last == run_id_) {
      r.outcome = Outcome::kFailed;
      r.counted = std::min<std::int64_t>(
          r.expected, std::int64_t(double(std::max(status_.at - 1, 0)) * config_.tick_s * 1e6 + 0.5));
    } else if (launched_ && (restarted_ || status_.running == run_id_)) {
      r.outcome = Outcome::kUnknown;
      r.unknown_to = r.expected;
    } else if (launched_) {
      paths_.unspend(part_);  // the robot has never started it
    }
  } else if (op_ == Op::kMove || op_ == Op::kHome) {
    r.outcome = Outcome::kFailed;
  }
  finish(std::move(r), fx);
}

bool Robot::upload_step() {
  RobotPaths::Use use;
  if (phase_ == Phase::kLoading) use.wanted = part_;
  if (phase_ == Phase::kRunning || (phase_ == Phase::kMoving && op_ == Op::kRun)) use.running = part_;
  use.ahead = config_.upload_ahead;
  use.block_lines = config_.block_lines;
  return paths_.step(use);
}

void Robot::upload_refused(std::string_view why, Effects& fx) {
  const auto refusal = paths_.refused(why);
  if (!refusal) return;
  const std::string path = "robot: path " + std::to_string(refusal->part.path);
  if (!refusal->given_up)
    return fault(Severity::kNotice, kCommandRejected, path + " again: " + std::string(why), fx);
  fault(Severity::kWarning, kCommandRejected, path + " does not load: " + std::string(why), fx);
  if (phase_ != Phase::kLoading || refusal->part != part_) return;
  finish({Outcome::kNone, -1, 0, 0, 0, kCommandRejected, std::string(why)}, fx);
  ready("path not loaded", fx);
}

// Orders of a person, beside a print (firn device).
void Robot::jog(std::span<const double> v, std::int64_t now_us, Effects& fx) {
  if (!where_) return refuse(kUnreachable, "where the robot stands is not known", fx);
  fvp::Joints to = fvp::joints_of(*where_);
  const auto joint = std::size_t(v[0]) - 1;
  to[joint] += joint == 2 ? v[1] : v[1] * kRadians;
  move_to(to, kJogPercent, now_us, fx);
}

void Robot::service(std::string_view verb, std::span<const double> v, std::int64_t now_us, Effects& fx) {
  const auto asked = [this](std::string_view question) {
    LineWriter line = fvp::request(seq(), question);
    return fvp::to_request(line, seq_, Repeat::kRead, kServiceTag);
  };
  Service s{std::string(verb), {}, 0, {}, nullptr};
  if (verb == "lines" && v.size() == 1) {
    if (!whole_within(v[0], 1, kMaxLines))
      return refuse(kLimit, "lines are a whole number, 1 to " + std::to_string(kMaxLines), fx);
    for (int n = 0; n < int(v[0]); ++n) s.begin.push_back(asked("STAT"));
    s.tell = [](const Request&, std::span<const std::byte> frame) -> std::optional<std::string> {
      WordReader words(fvp::parse(reply_text(frame)).text);
      return words.word() == "ACK" ? std::optional<std::string>("") : std::nullopt;
    };
    s.then = [n = v[0], begun_us = now_us](std::int64_t now, Effects& effects) {
      char text[80];
      const double took_s = double(now - begun_us) * 1e-6;
      std::snprintf(text, sizeof text, "%.0f lines in %.3f s: %.0f a second", n, took_s, n / took_s);
      effects.events.emplace_back(
          Result{Outcome::kDone, std::int64_t(n), std::int64_t(n), 0, 0, kNoCode, text});
    };
    return run_service(std::move(s));
  }
  if (verb != "where" && verb != "jog") return Driver::service(verb, v, now_us, fx);
  s.begin = {asked("STAT J")};
  s.tell = [this](const Request&, std::span<const std::byte> frame) -> std::optional<std::string> {
    WordReader words(fvp::parse(reply_text(frame)).text);
    if (words.word() != "ACK") return std::nullopt;
    const auto counts = fvp::parse_counts(words);
    if (!counts) return std::nullopt;
    where_ = *counts;
    const fvp::Joints j = fvp::joints_of(*counts);
    char text[100];
    std::snprintf(text, sizeof text, "J1 %.4f deg, J2 %.4f deg, J3 %.3f mm, J4 %.4f deg", j[0] / kRadians,
                  j[1] / kRadians, j[2], j[3] / kRadians);
    return text;
  };
  if (verb == "jog") {
    if (v.size() != 3 || !whole_within(v[0], 1, 4)) return refuse(kLimit, "a jog is of joint 1 to 4", fx);
    if (v[2] == 0.0 && !(std::abs(v[1]) <= kJog))
      return refuse(kLimit, "a jog is at most 5 deg or 5 mm; --far allows more", fx);
    s.then = [this, joint = v[0], by = v[1]](std::int64_t now, Effects& effects) {
      jog(std::array{joint, by}, now, effects);
    };
  }
  run_service(std::move(s));
}

}  // namespace firn::drivers
