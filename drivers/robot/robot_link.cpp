// Robot: link, stopping, the result of an interrupted command, and the upload of paths ahead of time.
#include "drivers/robot/robot.h"

#include <algorithm>

#include "drivers/link/crc16.h"

namespace firn::drivers {
namespace {

constexpr std::int64_t kStopLimit_us = 5'000'000, kStopPoll_us = 50'000;
constexpr int kWatchdog = int(fvp::Nak::kWatchdog);

std::string quoted_verb(const Request& request) {
  if (request.format == fvp::kBlock) return "'PATH P'";
  std::string_view text = fvp::parse(request.text()).text;
  return "'" + std::string(text) + "'";
}

constexpr int kMostTries = 3;

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
  abandon_upload();  // its requests may have been thrown away with the queue
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
  forget_slots();
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
    forget_slots();
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
      return uploaded(request, words.number(0, fvp::kMostId), fx);
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
    const auto id = std::int32_t(words.number(1, fvp::kMostId));
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
        if (id != 0 &&
            std::none_of(slots_.begin(), slots_.end(), [&](const Slot& s) { return s.id == id; })) {
          push(fvp::request(seq(), "PATH DROP").word(id), Repeat::kSetup, kDropSlot);
        }
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
      spent_.erase(part_);  // the robot has never started it
    }
  } else if (op_ == Op::kMove || op_ == Op::kHome) {
    r.outcome = Outcome::kFailed;
  }
  finish(std::move(r), fx);
}

Robot::Slot* Robot::slot_of(const PathPart& part) {
  for (Slot& s : slots_)
    if (s.id != 0 && s.part == part) return &s;
  return nullptr;
}

bool Robot::holds(const PathPart& part) const {
  return std::any_of(slots_.begin(), slots_.end(),
                     [&](const Slot& s) { return s.id != 0 && s.part == part && s.verified; });
}

void Robot::abandon_upload() {
  dialect_.points = {};
  upload_ = {};
}

void Robot::forget_slots() {
  abandon_upload();
  for (Slot& s : slots_) s = {};
}

void Robot::begin_upload(const PathPart& part, const Points& points, Slot& slot) {
  const bool again = slot.id != 0 && slot.part == part;
  const std::int32_t old_id = slot.id;
  const int tries = again ? upload_.tries : 0;
  last_id_ = last_id_ >= fvp::kMostId ? 1 : last_id_ + 1;
  slot = {last_id_, part, false};
  upload_ = {};
  upload_.slot = &slot;
  upload_.points = points;
  upload_.first = std::size_t(part.from);
  upload_.count = std::size_t(part.to - part.from + 1);
  upload_.tries = tries + 1;
  dialect_.points = std::span(*points).subspan(upload_.first, upload_.count);
  fvp::PointsCrc crc;
  for (const fvp::Counts& p : dialect_.points) crc.add(p);
  upload_.crc = crc.value();
  if (old_id != 0) push(fvp::request(seq(), "PATH DROP").word(old_id), Repeat::kSetup, kDropSlot);
  push(fvp::request(seq(), "PATH BEGIN")
           .word(last_id_)
           .text(" N=")
           .number(std::int64_t(upload_.count))
           .text(" DT=0.016"),
       Repeat::kSetup, kBegin);
}

// The part that a command waits for; else, while a slot is free, the next path in order.
bool Robot::choose_upload() {
  const bool wanted = phase_ == Phase::kLoading && !holds(part_);
  const bool running = phase_ == Phase::kRunning || (phase_ == Phase::kMoving && op_ == Op::kRun);
  Slot* free = nullptr;
  for (Slot& s : slots_) {
    if (running && s.part == part_ && s.id != 0) continue;
    const bool useless = s.id == 0 || !s.verified || !paths_.contains(s.part.path) ||
                         spent_.contains(s.part) || s.part.path < last_path_;
    if (useless || (wanted && !free)) free = &s;
    if (useless) break;
  }
  if (!free) return false;
  if (wanted) {
    begin_upload(part_, paths_.at(part_.path).points, *free);
    return true;
  }
  if (!config_.upload_ahead) return false;
  for (auto at = paths_.upper_bound(last_path_); at != paths_.end(); ++at) {
    const Points& points = at->second.points;
    if (!points || points->size() > std::size_t(fvp::kMostPoints)) continue;
    const PathPart part{at->first, 0, std::int32_t(points->size()) - 1};
    if (spent_.contains(part)) continue;
    if (slot_of(part)) return false;  // it is there already
    begin_upload(part, points, *free);
    return true;
  }
  return false;
}

bool Robot::upload_step() {
  if (!upload_.slot) return choose_upload();
  if (!upload_.begun) return false;  // its reply is still to come
  if (upload_.held < upload_.count) {
    const std::size_t block =
        std::min(upload_.count - upload_.held, std::size_t(config_.block_lines * fvp::kPointsPerLine));
    link_.push(fvp::path_block(seq(), upload_.held, block, kPoints));
  } else {
    char crc[4];
    put_hex4(crc, upload_.crc);
    push(fvp::request(seq(), "PATH END").word(std::string_view(crc, 4)), Repeat::kSetup, kEnd);
  }
  return true;
}

void Robot::uploaded(const Request& request, std::int64_t number, Effects& fx) {
  if (!upload_.slot) return;  // given up meanwhile
  switch (request.tag) {
    case kBegin:
      upload_.begun = true;
      return;
    case kPoints:
      if (std::size_t(number) > upload_.count) return upload_refused("more points held than sent", fx);
      if (std::size_t(number) <= upload_.held && ++upload_.tries > kMostTries)
        return upload_refused("no points are kept", fx);
      upload_.held = std::size_t(number);
      return;
    default:
      upload_.slot->verified = true;
      abandon_upload();
  }
}

void Robot::upload_refused(std::string_view why, Effects& fx) {
  if (!upload_.slot) return;
  const Upload was = upload_;
  const bool wanted = phase_ == Phase::kLoading && was.slot->part == part_;
  if (was.tries < kMostTries) {
    fault(Severity::kNotice, kCommandRejected,
          "robot: path " + std::to_string(was.slot->part.path) + " again: " + std::string(why), fx);
    return begin_upload(PathPart(was.slot->part), was.points, *was.slot);
  }
  fault(Severity::kWarning, kCommandRejected,
        "robot: path " + std::to_string(was.slot->part.path) + " does not load: " + std::string(why), fx);
  const std::int64_t path = was.slot->part.path;
  abandon_upload();
  paths_[path] = {nullptr, "the robot does not take it: " + std::string(why)};
  if (!wanted) return;
  finish({Outcome::kNone, -1, 0, 0, 0, kCommandRejected, std::string(why)}, fx);
  ready("path not loaded", fx);
}

}  // namespace firn::drivers
