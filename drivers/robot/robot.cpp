#include "drivers/robot/robot.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <string>

namespace firn::drivers {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

std::string joint_text(std::size_t joint, double value) {
  char text[48];
  if (joint == 2)
    std::snprintf(text, sizeof text, "%.3f mm", value);
  else
    std::snprintf(text, sizeof text, "%.4f deg", value / kDegree);
  return text;
}

// Why a trajectory is not for this robot [interlock 8]; empty = it is.
Figure joint_figure(std::size_t joint, double value, double limit, const char* per) {
  const double one = joint == 2 ? 1.0 : kDegree;
  return {value / one, limit / one, (joint == 2 ? "mm" : "deg") + std::string(per)};
}

Violation broken_path_limit(const RobotOptions& c, double tick_s, int axes,
                            std::span<const double> positions) {
  if (axes != 4 || positions.size() < 8 || positions.size() % 4 != 0)
    return {"the robot has 4 joints and needs two points, not " + std::to_string(axes) + " axes with " +
            std::to_string(positions.size()) + " positions"};
  if (tick_s != c.tick_s)
    return {"its tick is " + std::to_string(tick_s) + " s, the robot's " + std::to_string(c.tick_s) + " s",
            {tick_s, c.tick_s, "s"}};
  for (std::size_t n = 0; n < positions.size() / 4; ++n)
    for (std::size_t j = 0; j < 4; ++j) {
      const double q = positions[4 * n + j];
      const JointLimit& limit = c.limits[j];
      if (!(q >= limit.low && q <= limit.high))  // also NaN
        return {"sample " + std::to_string(n) + ": J" + std::to_string(j + 1) + " = " + joint_text(j, q) +
                    " is outside [" + joint_text(j, limit.low) + ", " + joint_text(j, limit.high) + "]",
                joint_figure(j, q, q < limit.low ? limit.low : limit.high, "")};
      const double rate = n == 0 ? 0.0 : std::abs(q - positions[4 * (n - 1) + j]) / tick_s;
      if (rate > limit.max_rate)
        return {"sample " + std::to_string(n) + ": J" + std::to_string(j + 1) + " would turn at " +
                    joint_text(j, rate) + "/s, more than " + joint_text(j, limit.max_rate) + "/s",
                joint_figure(j, rate, limit.max_rate, "/s")};
    }
  return {};
}

}  // namespace

// Ranges and rates: Table 2-1. A path may use less (4.10); the planner's certificate holds it to
// that.
RobotOptions::RobotOptions()
    : limits{{{-105.0 * kDegree, 105.0 * kDegree, 360.0 * kDegree, 360.0 * kDegree},
              {-150.0 * kDegree, 150.0 * kDegree, 672.0 * kDegree, 672.0 * kDegree},
              {0.0, 210.0, 1100.0, 1100.0},
              {-360.0 * kDegree, 360.0 * kDegree, 1200.0 * kDegree, 1200.0 * kDegree}}} {}

Robot::Robot(RobotOptions config)
    : Driver(dialect_),
      config_(std::move(config)),
      approach_percent_(int(std::lround(config_.approach_speed_percent))) {
  check_options("robot", kRobotConfig, config_);
  dialect_.allow_host_latency(config_.host_latency_s);
  check_options("robot", kRobotDialect, config_.dialect, "dialect.");
  identity_ = "Adept Cobra 600, C40";
}

std::optional<fvp::Joints> Robot::joints() const {
  return where_ ? std::optional(fvp::joints_of(*where_)) : std::nullopt;
}

void Robot::refuse(std::int32_t code, std::string text, Effects& fx, const Figure& figure) {
  Result r;
  r.outcome = Outcome::kRefused;
  r.code = code;
  r.text = std::move(text);
  r.figure = figure;
  fx.events.emplace_back(std::move(r));
}

void Robot::finish(Result result, Effects& fx) {
  op_ = Op::kNone;
  launched_ = false;
  ending_.clear();
  ending_code_ = kNoCode;
  way_.clear();
  fx.events.emplace_back(std::move(result));
}

void Robot::add_path(std::int64_t path, double tick_s, int axes, std::span<const double> positions,
                     std::int64_t now_us, Effects& fx) {
  if (!paths_.find(path)) {
    RobotPaths::Kept kept;
    kept.refusal = broken_path_limit(config_, tick_s, axes, positions);
    if (kept.refusal.empty()) {
      auto points = std::make_shared<std::vector<fvp::Counts>>(positions.size() / 4);
      for (std::size_t n = 0; n < points->size(); ++n)
        (*points)[n] = fvp::counts_of(
            {positions[4 * n], positions[4 * n + 1], positions[4 * n + 2], positions[4 * n + 3]});
      kept.points = std::move(points);
    } else {
      fault(Severity::kWarning, kUnreachable,
            "robot: path " + std::to_string(path) + " is refused: " + kept.refusal.text, fx,
            kept.refusal.figure);
    }
    paths_.keep(path, std::move(kept));
  }
  pump(now_us, fx);
}

bool Robot::accept(Op op, Effects& fx) {
  if (busy()) {
    refuse(kNoCode, "the robot is busy with another command", fx);
    return false;
  }
  if (op == Op::kHome && phase_ == Phase::kDead && link_.idle()) return true;  // the operator's reset
  if (phase_ != Phase::kReady) {
    refuse(kNoCode, std::string("the robot is ") + standing(), fx);
    return false;
  }
  if ((op == Op::kRun || op == Op::kMove) && !(status_.power && status_.calibrated)) {
    refuse(kLimit, status_.power ? "the robot is not calibrated" : "the robot has no arm power", fx);
    return false;
  }
  if (op == Op::kRun && status_.speed_percent != 100) {
    refuse(kTimeSlip, "monitor SPEED is " + std::to_string(status_.speed_percent) + ", not 100", fx);
    return false;
  }
  return true;
}

bool Robot::runnable(const PathPart& part, Effects& fx) {
  const std::string which = "path " + std::to_string(part.path);
  const RobotPaths::Kept* kept = paths_.find(part.path);
  if (!kept) {
    refuse(kNoCode, which + " has not been received", fx);
    return false;
  }
  if (!kept->refusal.empty()) {
    refuse(kUnreachable, which + ": " + kept->refusal.text, fx, kept->refusal.figure);
    return false;
  }
  const auto n = std::int64_t(kept->points->size());
  const std::int64_t last = part.to == 0 ? n - 1 : part.to;
  if (part.from < 0 || last >= n || last <= part.from) {
    refuse(kLimit,
           which + ": samples " + std::to_string(part.from) + " to " + std::to_string(last) +
               " are not within its " + std::to_string(n),
           fx);
    return false;
  }
  if (last - part.from + 1 > fvp::kMaxPoints) {
    refuse(kLimit,
           which + ": " + std::to_string(last - part.from + 1) + " points are more than the robot's " +
               std::to_string(fvp::kMaxPoints) + " (131.072 s)",
           fx);
    return false;
  }
  part_ = {part.path, part.from, std::int32_t(last)};
  part_points_ = std::size_t(last - part.from + 1);
  first_point_ = (*kept->points)[std::size_t(part.from)];
  last_point_ = (*kept->points)[std::size_t(last)];
  return true;
}

void Robot::load(const PathPart& part, std::int64_t now_us, Effects& fx) {
  if (accept(Op::kLoad, fx) && runnable(part, fx)) {
    op_ = Op::kLoad;
    phase_ = Phase::kLoading;
    paths_.set_last(part.path);
  }
  pump(now_us, fx);
}

void Robot::run(const PathPart& part, int signals, std::int64_t now_us, Effects& fx) {
  const bool deposits = signals & (kSignalValveA | kSignalValveB);
  if (accept(Op::kRun, fx) && runnable(part, fx)) {
    if (paths_.spent(part_)) {
      refuse(kNoCode, "path " + std::to_string(part.path) + " was started before and is never run again", fx);
    } else {
      op_ = Op::kRun;
      signals_ = signals;
      path_over_ = false;
      paths_.set_last(part.path);
      if (deposits) paths_.forget_before(part.path);
      phase_ = Phase::kLoading;
      set_state(DeviceState::kStaged, "path " + std::to_string(part.path), fx);
    }
  }
  pump(now_us, fx);
}

void Robot::move_to(const fvp::Joints& target, int percent, std::int64_t now_us, Effects& fx) {
  if (accept(Op::kMove, fx)) {
    std::string why;
    for (std::size_t j = 0; j < 4; ++j)
      if (!(target[j] >= config_.limits[j].low && target[j] <= config_.limits[j].high))
        why = "J" + std::to_string(j + 1) + " = " + joint_text(j, target[j]) + " is outside [" +
              joint_text(j, config_.limits[j].low) + ", " + joint_text(j, config_.limits[j].high) + "]";
    if (percent < 0 || percent > 100)
      why = "a speed of " + std::to_string(percent) + " % is outside [0, 100]";
    if (!where_) why = "where the robot stands is not known";
    if (!why.empty()) {
      refuse(kUnreachable, why, fx);
    } else {
      op_ = Op::kMove;
      phase_ = Phase::kMoving;
      plan_way(fvp::counts_of(target), percent == 0 ? approach_percent_ : percent);
      set_state(DeviceState::kActive, "moving", fx);
    }
  }
  pump(now_us, fx);
}

void Robot::decline(const std::string& why, std::int64_t now_us, Effects& fx) {
  refuse(kUnreachable, why, fx);
  pump(now_us, fx);
}

void Robot::home(std::int64_t now_us, Effects& fx) {
  if (accept(Op::kHome, fx)) {
    op_ = Op::kHome;
    phase_ = Phase::kHoming;
    step_ = 0;
    set_state(DeviceState::kActive, "power and calibration", fx);
  }
  pump(now_us, fx);
}

void Robot::drop(std::int64_t path, std::int64_t now_us, Effects& fx) {
  if (busy()) {
    refuse(kNoCode, "the robot is busy with another command", fx);
  } else {
    paths_.drop(path);
    fx.events.emplace_back(Result{});
  }
  pump(now_us, fx);
}

std::int64_t Robot::planned_us() const {
  return std::llround(double(part_points_ == 0 ? 0 : part_points_ - 1) * config_.tick_s * 1e6);
}

void Robot::begin_way() {
  way_.clear();
  way_at_ = 0;
  move_over_ = false;
  poll_at_us_ = limit_us_ = 0;
}

void Robot::plan_way(const fvp::Counts& to, int percent) {
  begin_way();
  // Encoders are coarser than the first point of a path: the commanded position counts, not the position that
  // it says it is.
  const fvp::Counts from = commanded_.value_or(*where_);
  const bool turns = !commanded_ || from[0] != to[0] || from[1] != to[1] || from[3] != to[3];
  if (turns) {
    const double hop_mm = (std::max(from[2], to[2])) / 1e3 + config_.approach_hop_mm;
    const auto top = std::int32_t(std::llround(std::min(hop_mm, config_.limits[2].high) * 1e3));
    fvp::Counts above = from;
    above[2] = std::max(top, from[2]);
    if (from[2] != above[2]) way_.push_back({true, above, percent});
    fvp::Counts over = to;
    over[2] = above[2];
    way_.push_back({false, over, percent});
    if (over[2] != to[2]) way_.push_back({true, to, percent});
  } else if (from[2] != to[2]) {
    way_.push_back({true, to, percent});
  }
}

void Robot::start_move(const Target& target, std::int64_t now_us) {
  LineWriter line = fvp::request(seq(), target.only_z ? "MOVEZ" : "MOVEJ");
  double longest_s = 0.0;
  for (std::size_t j = target.only_z ? 2 : 0; j < (target.only_z ? 3u : 4u); ++j) {
    line.word(target.counts[j]);
    const double full = j == 2 ? config_.limits[j].move_rate * 1e3
                               : double(fvp::counts_of({config_.limits[j].move_rate, 0.0, 0.0, 0.0})[0]);
    const double way = where_ ? std::abs(double(target.counts[j]) - double((*where_)[j])) : 0.0;
    longest_s = std::max(longest_s, way / (full * target.percent / 100.0));
  }
  line.word(target.percent);
  push(line, Repeat::kNever, kMove);
  move_over_ = false;
  poll_at_us_ = now_us + std::int64_t(config_.poll_moving_s * 1e6);
  limit_us_ = now_us + std::int64_t((longest_s * config_.stall_factor + config_.motion_margin_s +
                                     2.0 * config_.host_latency_s) *
                                    1e6);
}

// Of the move that was started last: an event says that it is over, or the status does.
Robot::Motion Robot::motion(std::int64_t now_us) {
  if (move_over_) return Motion::kOver;
  if (now_us < poll_at_us_) return Motion::kWaiting;
  if (poll_at_us_ != 0 && status_.state != fvp::State::kRunning && where_) {
    move_over_ = true;  // asked after the move had begun, and it stands
    return Motion::kOver;
  }
  poll_at_us_ = now_us + std::int64_t(config_.poll_moving_s * 1e6);
  ask("STAT", kStat);
  ask("STAT J", kWhere);
  return Motion::kAsked;
}

bool Robot::moving_step(std::int64_t now_us, Effects& fx) {
  if (limit_us_ != 0) {
    const Motion m = motion(now_us);
    if (m != Motion::kOver) return m == Motion::kAsked;
    const Target& there = way_[way_at_++];
    if (!there.only_z || commanded_) commanded_ = there.counts;
    limit_us_ = 0;
  }
  if (way_at_ < way_.size()) {
    start_move(way_[way_at_], now_us);
    return true;
  }
  if (op_ == Op::kRun) {
    start_path(now_us, fx);
    return true;
  }
  low_ = low_ || op_ == Op::kMove;
  if (op_ == Op::kHome) low_ = false;
  const char* what = op_ == Op::kHome ? "homed" : "move done";
  finish({Outcome::kDone, -1, 0, 0, 0, kNoCode, {}}, fx);
  ready(what, fx);
  return true;
}

void Robot::start_path(std::int64_t now_us, Effects& fx) {
  const RobotPaths::Slot* slot = paths_.slot_of(part_);
  if (!slot) return begin_stop(now_us, fx, "the robot has lost the path", kInstrument);
  phase_ = Phase::kStarting;
  run_id_ = slot->id;
  if (signals_ & (kSignalValveA | kSignalValveB)) paths_.spend(part_);
  launched_ = true;
  low_ = true;
  commanded_.reset();
  push(fvp::request(seq(), "PATH RUN").word(run_id_).word(signals_), Repeat::kNever, kRunPath);
}

void Robot::complete_run(Effects& fx) {
  const std::int64_t took_us = std::int64_t(took_ms_) * 1000, planned = planned_us();
  Result r{Outcome::kDone, took_us, planned, 0, 0, kNoCode, {}};
  if (std::abs(took_us - planned) > std::llround(config_.slip_s * 1e6)) {
    ++slips_;
    r.code = kTimeSlip;
    r.text = "path " + std::to_string(part_.path) + " took " + std::to_string(took_us / 1000) +
             " ms, planned " + std::to_string(planned / 1000) + " ms";
    r.figure = {double(std::abs(took_us - planned)) * 1e-3, config_.slip_s * 1e3, "ms",
                "ice.max_time_slip_s"};
    fault(slips_ > 1 ? Severity::kStop : Severity::kWarning, kTimeSlip, "robot: " + r.text, fx, r.figure);
  } else {
    slips_ = 0;
  }
  commanded_ = last_point_;
  if (signals_ & (kSignalValveA | kSignalValveB)) paths_.let_overwrite(part_);
  finish(std::move(r), fx);
}

bool Robot::running_step(std::int64_t now_us, Effects& fx) {
  if (path_over_) {
    complete_run(fx);
    ready("path done", fx);
    return true;
  }
  if (now_us >= poll_at_us_) {
    poll_at_us_ = now_us + 100'000;
    ask("STAT", kStat);
    return true;
  }
  if (upload_step()) return true;
  if (now_us - link_.last_sent_us() < std::int64_t(config_.hb_s * 1e6)) return false;
  ask("HB", kBeat);
  return true;
}

bool Robot::homing_step(std::int64_t now_us, Effects& fx) {
  const auto fail = [&](std::string why, std::int32_t code) {
    begin_stop(now_us, fx, std::move(why), code);
    return true;
  };
  const auto poll = [&] {
    if (now_us < poll_at_us_) return false;
    poll_at_us_ = now_us + std::int64_t(config_.poll_moving_s * 1e6);
    ask("STAT", kStat);
    return true;
  };
  switch (step_) {
    case 0:
      order("CLEAR", kHarmless);
      push(fvp::request(seq(), "SPEED").word(100), Repeat::kSetup, kSpeed);
      ask("STAT", kStat);
      step_ = 1;
      return true;
    case 1:
      if (status_.state == fvp::State::kEstop || status_.state == fvp::State::kFault) {
        doom_ = status_.state == fvp::State::kEstop
                    ? Doom{DeviceState::kEstop, kEstop, "the emergency stop is still pressed"}
                    : Doom{DeviceState::kFault, kAxisFault, "the fault cannot be cleared"};
        return fail(doom_->text, doom_->code);
      }
      if (status_.speed_percent != 100)
        return fail("monitor SPEED stays at " + std::to_string(status_.speed_percent) + ", not 100",
                    kTimeSlip);
      if (!status_.power) order("POWER 1");
      limit_us_ = now_us + std::int64_t(config_.dialect.power_s * 1e6);
      poll_at_us_ = now_us;
      step_ = 2;
      return true;
    case 2:
      if (!status_.power) return now_us >= limit_us_ ? fail("no arm power", kStall) : poll();
      if (!status_.calibrated) order("CAL");
      limit_us_ = now_us + std::int64_t(config_.dialect.calibration_s * 1e6);
      poll_at_us_ = now_us;
      step_ = 3;
      return true;
    case 3:
      if (!status_.calibrated || status_.state == fvp::State::kRunning)
        return now_us >= limit_us_ ? fail("the calibration does not end", kStall) : poll();
      ask("STAT J", kWhere);
      step_ = 4;
      return true;
    default: {
      if (!where_) return fail("where it stands is not known", kInstrument);
      const double z_mm = std::min(config_.home_z_mm, config_.limits[2].high);
      Target up{true, *where_, approach_percent_};
      up.counts[2] = std::int32_t(std::llround(z_mm * 1e3));
      begin_way();
      if (up.counts[2] > (*where_)[2]) way_.push_back(up);
      phase_ = Phase::kMoving;
      return true;
    }
  }
}

bool Robot::idle(std::int64_t now_us, Effects& fx) {
  switch (phase_) {
    case Phase::kDown:
      return false;
    case Phase::kHello:  // whatever it was doing ends
      phase_ = Phase::kReady;
      begin_stop(now_us, fx, "a new connection", kNoCode);
      return true;
    case Phase::kStopping:
      return stopping_step(now_us, fx);
    case Phase::kHoming:
      return homing_step(now_us, fx);
    case Phase::kMoving:
      return moving_step(now_us, fx) || upload_step();
    case Phase::kRunning:
      return running_step(now_us, fx);
    case Phase::kStarting:  // the reply to PATH RUN changes it
      return false;
    case Phase::kLoading:
      if (!holds(part_)) return upload_step();
      if (op_ == Op::kLoad) {
        finish({Outcome::kDone, std::int64_t(part_points_), std::int64_t(part_points_), 0, 0, kNoCode, {}},
               fx);
        ready("path held", fx);
      } else if (!where_) {
        ask("STAT J", kWhere);
      } else {
        phase_ = Phase::kMoving;
        low_ = true;
        plan_way(first_point_, approach_percent_);
        set_state(DeviceState::kActive, "path " + std::to_string(part_.path), fx);
      }
      return true;
    case Phase::kReady:
      if (upload_step()) return true;
      [[fallthrough]];
    case Phase::kDead:
      if (now_us - link_.last_sent_us() < std::int64_t(config_.dialect.poll_idle_s * 1e6)) return false;
      ask("STAT", kStat);
      return true;
  }
  return false;
}

void Robot::tick(std::int64_t now_us, Effects& fx) {
  if (limit_us_ == 0 || now_us < limit_us_) return;
  if (phase_ == Phase::kRunning && !path_over_) {
    const std::string why = "path " + std::to_string(part_.path) + " is not over in time";
    fault(Severity::kStop, kStall, "robot: " + why, fx);
    begin_stop(now_us, fx, why, kStall);
  } else if (phase_ == Phase::kMoving && !move_over_) {
    fault(Severity::kStop, kStall, "robot: a move is not over in time", fx);
    begin_stop(now_us, fx, "a move was not over in time", kStall);
  } else if (phase_ == Phase::kRunning || phase_ == Phase::kMoving) {
    limit_us_ = std::numeric_limits<std::int64_t>::max();  // it is over: a reply is awaited, and no more
  }
}

std::int64_t Robot::device_wake_us() const {
  const bool timed = phase_ == Phase::kRunning || phase_ == Phase::kMoving;
  std::int64_t wake = timed ? limit_us_ : 0;
  if (!link_.idle()) return wake;
  std::int64_t next = 0;
  switch (phase_) {
    case Phase::kReady:
    case Phase::kDead:
      next = link_.last_sent_us() + std::int64_t(config_.dialect.poll_idle_s * 1e6);
      break;
    case Phase::kRunning:
      next = std::min(poll_at_us_, link_.last_sent_us() + std::int64_t(config_.hb_s * 1e6));
      break;
    case Phase::kMoving:
    case Phase::kStopping:
    case Phase::kHoming:
      next = poll_at_us_;
      break;
    default:
      break;
  }
  return next != 0 && (wake == 0 || next < wake) ? next : wake;
}

}  // namespace firn::drivers
