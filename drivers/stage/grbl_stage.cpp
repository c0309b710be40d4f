#include "drivers/stage/grbl_stage.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>

#include "drivers/stage/stage_service.h"

namespace firn::drivers {

using grbl::fixed;

namespace {

constexpr double kUnknown_mm = std::numeric_limits<double>::quiet_NaN();
constexpr double kSlack_s = 1.0;  // of the planner, beyond the plan of a motion

}  // namespace

GrblStage::GrblStage(StageOptions config) : StageDriver(dialect_, std::move(config)) {
  check_options("stage", kStageDialect, config_.dialect, "dialect.");
  dialect_.allow_host_latency(config_.host_latency_s);
  identity_ = "GRBL";
  position_mm_.fill(kUnknown_mm);
}

bool GrblStage::accepts(Op op, Effects& fx) {
  if (busy()) {
    refuse(kNoCode, "the stage is busy with another command", fx);
    return false;
  }
  if (op == Op::kHome && phase_ == Phase::kDead && link_.idle()) return true;  // the operator's reset
  if (phase_ != Phase::kReady) {
    refuse(kNoCode, std::string("the stage is ") + standing(), fx);
    return false;
  }
  if (op != Op::kHome && !homed_) {
    refuse(kLimit, "the stage is not homed: its board does not know where it is", fx);
    return false;
  }
  return true;
}

void GrblStage::begin(Op op, std::string_view text, Effects& fx) {
  op_ = op;
  run_ = 0;
  before_ = 0;
  launched_ = false;
  lines_.clear();
  next_line_ = 0;
  ending_.clear();
  ending_code_ = kNoCode;
  set_state(DeviceState::kActive, text, fx);
}

double GrblStage::step_mm(std::size_t axis) const {
  const double steps = setting(grbl::kSteps + int(axis));
  return steps > 0.0 ? 1.0 / steps : config_.dialect.tolerance_mm;
}

// The output is high while the stage travels so far: two steps, which the board cannot leave out, or longer.
double GrblStage::pulse_mm(double speed_mm_s) const {
  return std::max(speed_mm_s * config_.dialect.pulse_on_us * 1e-6, 2.0 * step_mm(0));
}

std::string GrblStage::rate_refusal(const PassPlan& plan) const {
  char text[200];
  for (const RasterRun& run : plan.runs) {
    const double pulse = pulse_mm(run.speed_mm_s);
    for (std::size_t n = 1; n < run.increments.size(); ++n) {
      const double apart_mm = double(run.increments[n]) / config_.counts_per_mm;
      if (apart_mm < 2.0 * pulse) {
        std::snprintf(
            text, sizeof text,
            "row %d: droplets %.4f mm apart; a pulse of the laser output is %.4f mm long at %.3g mm/s",
            run.row, apart_mm, pulse, run.speed_mm_s);
        return text;
      }
      const double lines_per_s = 2.0 * run.speed_mm_s / apart_mm;
      if (lines_per_s > config_.lines_per_s) {
        std::snprintf(text, sizeof text,
                      "row %d: %.3g droplets/s are %.3g lines/s; the board takes stage.lines_per_s = %.3g",
                      run.row, lines_per_s / 2.0, lines_per_s, config_.lines_per_s);
        return text;
      }
    }
  }
  return {};
}

void GrblStage::run_pass(const DropletPattern& pattern, int pass, double z_mm, double speed_mm_s,
                         std::int64_t now_us, Effects& fx, double lead_mm, const Placement& placement) {
  PassPlan plan;
  if (accepts(Op::kPass, fx)) {
    auto why = plan_pass(pattern, pass, z_mm, speed_mm_s, lead_mm, placement, plan);
    if (!why && !on(config_.laser_output))
      why = Refusal{kInstrument, "stage.laser_output = \"off\": no output of the board triggers a jet"};
    if (!why)
      if (std::string rate = rate_refusal(plan); !rate.empty()) why = Refusal{kLimit, std::move(rate)};
    if (why) {
      refuse(why->code, std::move(why->text), fx);
    } else {
      runs_ = std::move(plan.runs);
      expected_ = plan.expected;
      speed_mm_s_ = plan.speed_mm_s;
      z_mm_ = z_mm;
      begin(Op::kPass, "raster pass", fx);
      if (runs_.empty())
        finish({Outcome::kDone, 0, 0, 0, 0, kNoCode, "no droplets in this pass"}, fx);
      else
        phase_ = Phase::kPlacing;
    }
  }
  pump(now_us, fx);
}

void GrblStage::scan(double x_mm, double y_mm, double z_mm, double pitch_mm, int rows, double speed_mm_s,
                     std::int64_t now_us, Effects& fx) {
  ScanPlan plan;
  if (accepts(Op::kScan, fx)) {
    auto why = plan_scan(x_mm, y_mm, z_mm, pitch_mm, rows, speed_mm_s, plan);
    if (!why && !on(config_.scan_box))
      why = Refusal{
          kInstrument,
          "stage.scan_box = \"off\": a GRBL board triggers no profiler; a box that counts the Y steps does"};
    if (why) {
      refuse(why->code, std::move(why->text), fx);
    } else {
      runs_.clear();
      expected_ = rows;
      speed_mm_s_ = plan.speed_mm_s;
      pitch_mm_ = plan.pitch_mm;
      z_mm_ = z_mm;
      begin(Op::kScan, "scan", fx);
      target_mm_ = {x_mm, y_mm - plan.pitch_mm, z_mm};
      phase_ = Phase::kPlacing;
    }
  }
  pump(now_us, fx);
}

void GrblStage::move_to(double x_mm, double y_mm, double z_mm, double speed_mm_s, std::int64_t now_us,
                        Effects& fx) {
  const std::array<double, 3> target{x_mm, y_mm, z_mm};
  double speed = speed_mm_s;
  if (accepts(Op::kMove, fx)) {
    if (auto why = plan_move(target, speed)) {
      refuse(why->code, std::move(why->text), fx);
    } else {
      runs_.clear();
      expected_ = 0;
      speed_mm_s_ = speed;
      begin(Op::kMove, "move", fx);
      target_mm_ = target;
      if (std::ranges::all_of(target, [](double mm) { return std::isnan(mm); }))
        finish({Outcome::kDone, -1, 0, 0, 0, kNoCode, "no axis to move"}, fx);
      else
        phase_ = Phase::kPlacing;
    }
  }
  pump(now_us, fx);
}

void GrblStage::trace(StageWay, double, std::int64_t now_us, Effects& fx) {
  refuse(kInstrument, "a GRBL board follows no ways with a shutter", fx);
  pump(now_us, fx);
}

void GrblStage::home(std::int64_t now_us, Effects& fx) {
  if (accepts(Op::kHome, fx)) {
    begin(Op::kHome, "homing", fx);
    phase_ = Phase::kHoming;
    push_homing();
  }
  pump(now_us, fx);
}

void GrblStage::service(std::string_view verb, std::span<const double> v, std::int64_t now_us, Effects& fx) {
  if (verb == "where" && v.empty()) {
    char text[100];
    std::snprintf(text, sizeof text, "X %.4f, Y %.4f, Z %.4f mm", position_mm_[0], position_mm_[1],
                  position_mm_[2]);
    fx.events.emplace_back(Result{Outcome::kDone, -1, 0, 0, 0, kNoCode, text});
  } else if (verb == "params" && v.empty()) {
    std::string text;
    for (const auto& [number, value] : settings_)
      text += (text.empty() ? "$" : ", $") + std::to_string(number) + fixed("=%g", value);
    fx.events.emplace_back(Result{Outcome::kDone, -1, 0, 0, 0, kNoCode, std::move(text)});
  } else if (verb == "serial" && v.empty()) {
    fx.events.emplace_back(Result{Outcome::kDone, -1, 0, 0, 0, kNoCode, identity_});
  } else if (verb == "jog" && v.size() == 5) {
    if (const auto why = jog_refused(v)) return refuse(kLimit, *why, fx);
    std::array<double, 3> to{kUnknown_mm, kUnknown_mm, kUnknown_mm};
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (v[axis] != 0.0) to[axis] = position_mm_[axis] + v[axis];
    move_to(to[0], to[1], to[2], v[3], now_us, fx);
  } else {
    StageDriver::service(verb, v, now_us, fx);
  }
}

void GrblStage::expect_end(double mm, double speed_mm_s, std::int64_t now_us) {
  const double plan_s = move_time_s(mm, speed_mm_s, config_.acceleration_mm_s2);
  until_us_ =
      now_us +
      std::int64_t((plan_s * config_.move_timeout_factor + kSlack_s + 2.0 * config_.host_latency_s) * 1e6);
  ask_us_ = now_us + kAskMoving_us;
}

/// A straight move from rest to rest; NaN = axis stays.
void GrblStage::go(const std::array<double, 3>& target_mm, double speed_mm_s, std::int64_t now_us) {
  std::string text = "G1";
  double squared = 0.0;
  for (std::size_t a = 0; a < 3; ++a) {
    if (std::isnan(target_mm[a])) continue;
    text += std::string(" ") + kAxisNames[a] + fixed("%.4f", target_mm[a]);
    squared += (target_mm[a] - position_mm_[a]) * (target_mm[a] - position_mm_[a]);
    target_mm_[a] = target_mm[a];
  }
  lines_ = {text + fixed(" F%.2f", speed_mm_s * 60.0) + " S0"};
  next_line_ = 0;
  expect_end(std::sqrt(squared), speed_mm_s, now_us);
}

/// The next part of the order, from a stage that stands at a place that is known.
void GrblStage::go_on(std::int64_t now_us, Effects&) {
  phase_ = Phase::kToStart;
  const double z_mm = std::abs(z_mm_ - position_mm_[2]) <= config_.dialect.tolerance_mm ? kUnknown_mm : z_mm_;
  if (op_ == Op::kPass)
    return go({runs_[run_].start_x_mm, runs_[run_].y_mm, z_mm}, config_.move_speed_mm_s, now_us);
  if (op_ == Op::kScan) return go({target_mm_[0], target_mm_[1], z_mm}, config_.move_speed_mm_s, now_us);
  go(target_mm_, speed_mm_s_, now_us);
}

// A pulse is a short piece of the way with the output on: it comes by the place, whatever the board's speed
// is.
void GrblStage::start_run(std::int64_t now_us) {
  phase_ = Phase::kRunning;
  launched_ = true;
  next_line_ = 0;
  if (op_ == Op::kScan) {
    const double end_y_mm = target_mm_[1] + (double(expected_) + 0.5) * pitch_mm_;
    lines_ = {"M8", "G1 Y" + fixed("%.4f", end_y_mm) + fixed(" F%.2f", speed_mm_s_ * 60.0) + " S0", "M9"};
    expect_end(end_y_mm - target_mm_[1], speed_mm_s_, now_us);
    target_mm_[1] = end_y_mm;
    return;
  }
  const RasterRun& run = runs_[run_];
  const double direction = run.end_x_mm >= run.start_x_mm ? 1.0 : -1.0, pulse = pulse_mm(run.speed_mm_s);
  const std::string power = fixed(" S%.0f", setting(grbl::kMaxPower));
  lines_ = {"M3 S0", "G1" + fixed(" F%.2f", run.speed_mm_s * 60.0)};
  std::int64_t counts = 0;
  for (const std::int64_t increment : run.increments) {
    counts += increment;
    const double at_mm = run.start_x_mm + direction * double(counts) / config_.counts_per_mm;
    lines_.push_back("X" + fixed("%.4f", at_mm) + " S0");
    lines_.push_back("X" + fixed("%.4f", at_mm + direction * pulse) + power);
  }
  lines_.push_back("X" + fixed("%.4f", run.end_x_mm) + " S0");
  lines_.push_back("M5");
  const double way_mm = std::abs(run.end_x_mm - run.start_x_mm);
  expect_end(way_mm, run.speed_mm_s, now_us);
  until_us_ += std::int64_t(double(lines_.size()) / config_.lines_per_s * 1e6);
  target_mm_[0] = run.end_x_mm;
}

/// It stands, and has no line left.
void GrblStage::arrived(std::int64_t now_us, Effects& fx) {
  for (std::size_t a = 0; a < 3; ++a) {
    const double off_mm = std::abs(position_mm_[a] - target_mm_[a]);
    if (std::isnan(target_mm_[a]) || off_mm <= config_.dialect.tolerance_mm + step_mm(a)) continue;
    char text[120];
    std::snprintf(text, sizeof text, "axis %c stands at %.4f mm instead of %.4f mm", kAxisNames[a],
                  position_mm_[a], target_mm_[a]);
    fault(Severity::kStop, kStall, std::string("stage: ") + text, fx);
    return hold(text, kStall, now_us, fx);
  }
  if (phase_ == Phase::kToStart && (op_ == Op::kPass || op_ == Op::kScan)) return start_run(now_us);
  launched_ = false;
  if (op_ == Op::kPass) {
    before_ += std::int64_t(runs_[run_].increments.size());
    if (++run_ < runs_.size()) return go_on(now_us, fx);
  }
  phase_ = Phase::kReady;
  set_state(DeviceState::kSafe, "at rest", fx);
  finish({Outcome::kDone, -1, expected_, 0, 0, kNoCode, ""}, fx);  // the end of its move is the evidence
}

void GrblStage::finish(Result result, Effects& fx) {
  if (op_ == Op::kNone) return;
  op_ = Op::kNone;
  if (phase_ == Phase::kPlacing) phase_ = Phase::kReady;
  if (phase_ == Phase::kReady) set_state(DeviceState::kSafe, "at rest", fx);
  fx.events.emplace_back(std::move(result));
}

/// The end of an order that was broken off. The board counts no pulses: those of the run are in doubt.
void GrblStage::settled(Effects& fx) {
  Result r{launched_ ? Outcome::kFailed : Outcome::kNone,
           launched_ ? -1 : 0,
           expected_,
           0,
           0,
           ending_code_,
           ending_};
  if (op_ == Op::kPass) {
    r.counted = r.unknown_from = r.unknown_to = before_;
    if (launched_) {
      r.outcome = Outcome::kUnknown;
      r.unknown_to += std::int64_t(runs_[run_].increments.size());
    } else if (before_ > 0) {
      r.outcome = Outcome::kFailed;
    }
  } else if (op_ == Op::kMove || op_ == Op::kHome) {
    r.outcome = Outcome::kFailed;
    r.counted = -1;
  }
  launched_ = false;
  ending_.clear();
  ending_code_ = kNoCode;
  finish(std::move(r), fx);
}

bool GrblStage::idle(std::int64_t now_us, Effects&) {
  if (next_line_ < lines_.size() && (phase_ == Phase::kToStart || phase_ == Phase::kRunning)) {
    // A full planner answers when a piece is over.
    const std::int64_t left_us = std::max<std::int64_t>(0, until_us_ - now_us);
    link_.push(grbl::line(lines_[next_line_++], kSpan, Repeat::kNever, left_us + 1'000'000));
    return true;
  }
  if (phase_ == Phase::kPlacing) {
    link_.push(grbl::status(kLook));
    return true;
  }
  const bool moving = phase_ == Phase::kToStart || phase_ == Phase::kRunning;
  if (!moving && phase_ != Phase::kReady) return false;
  const std::int64_t ask_us =
      moving ? ask_us_ : link_.last_sent_us() + std::int64_t(config_.poll_idle_s * 1e6);
  if (now_us < ask_us) return false;
  ask_us_ = now_us + kAskMoving_us;
  link_.push(grbl::status(kLook));
  return true;
}

void GrblStage::tick(std::int64_t now_us, Effects& fx) {
  if (phase_ == Phase::kHolding && link_.is_open()) {
    if (now_us >= until_us_) {  // it says nothing, or goes on moving: the reset cuts the steps
      fx.tx.push_back(std::byte(grbl::kReset));
      homed_ = false;
      fault(Severity::kStop, kStall, "stage: it does not say that it stands; it was reset, its place is lost",
            fx);
      return reconnect(now_us, fx, "it does not say that it stands");
    }
    if (now_us >= ask_us_) {
      fx.tx.push_back(std::byte(grbl::kStatus));
      ask_us_ = now_us + kAskMoving_us;
    }
  }
  if ((phase_ == Phase::kToStart || phase_ == Phase::kRunning) && now_us >= until_us_) {
    fault(Severity::kStop, kStall, "stage: the motion is not over in its time", fx);
    hold("the motion is not over in its time", kStall, now_us, fx);
  }
}

std::int64_t GrblStage::device_wake_us() const {
  switch (phase_) {
    case Phase::kHolding:
      return std::min(ask_us_, until_us_);
    case Phase::kToStart:
    case Phase::kRunning:
      return link_.idle() ? std::min(ask_us_, until_us_) : until_us_;
    case Phase::kReady:
      return link_.idle() ? link_.last_sent_us() + std::int64_t(config_.poll_idle_s * 1e6) : 0;
    default:
      return 0;
  }
}

}  // namespace firn::drivers
