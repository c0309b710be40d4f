#include "drivers/stage/stage.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <stdexcept>

#include "drivers/stage/stage_service.h"

namespace firn::drivers {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kSettlePoll_s = 0.005;
constexpr double kServicePulseRate_hz = 100.0;

}  // namespace

using ensemble::Line;

Stage::Stage(StageOptions config) : StageDriver(dialect_, std::move(config)) {
  const StageDialect& d = config_.dialect;
  check_options("stage", kStageDialect, d, "dialect.");
  const auto character = [](const char* what, const std::string& text) {
    if (text.size() != 1)
      throw std::invalid_argument(std::string("stage: dialect.") + what + " = \"" + text +
                                  "\" is no one character");
    return text[0];
  };
  ensemble::Table& t = config_.table;
  t.ok = character("ok", d.ok);
  t.nak = character("nak", d.nak);
  t.fault = character("fault", d.fault);
  t.timeout = character("timeout", d.timeout);
  t.home = d.home;
  t.home_program = d.home_program;
  t.stop_program = d.stop_program;
  t.home_count_iglobal = d.home_count_iglobal;
  t.home_axis_iglobal = d.home_axis_iglobal;
  t.feedback_input = d.feedback_input;
  config_.table.array_limit = config_.array_limit;
  config_.table.first_iglobal = config_.first_iglobal;
  if (config_.pulse_count == PulseCounter::kNone)
    config_.table.pulse_count.clear();
  else if (config_.pulse_count == PulseCounter::kPsostatus)
    config_.table.pulse_count = "PSOSTATUS(@)";
  dialect_.table = config_.table;
  dialect_.timeouts.quiet_us = std::int64_t(config_.quiet_s * 1e6);
  dialect_.allow_host_latency(config_.host_latency_s);
  identity_ = "Aerotech Ensemble";
  position_mm_.fill(kNaN);
  target_mm_.fill(kNaN);
}

// Orders of a person, beside a print (firn device).
void Stage::service(std::string_view verb, std::span<const double> v, std::int64_t now_us, Effects& fx) {
  Service s{std::string(verb),
            {},
            0,
            {},
            [this](const Request& request, std::span<const std::byte> frame) -> std::optional<std::string> {
              const ensemble::Reply r = dialect_.parse(frame);
              if (r.kind != ensemble::Reply::Kind::kOk) return std::nullopt;
              if (const auto axis = asked_place(request)) position_mm_[*axis] = r.number().value_or(kNaN);
              return service_answer(request, r, identity_);
            }};
  if (verb == "jog" && v.size() == 5) {
    if (const auto why = jog_refused(v)) return refuse(kLimit, *why, fx);
    s.begin = service_questions(verb, config_.table);
    s.then = [this, by = std::array{v[0], v[1], v[2]}, speed = v[3]](std::int64_t now, Effects& effects) {
      std::array<double, 3> to{kNaN, kNaN, kNaN};
      for (std::size_t axis = 0; axis < 3; ++axis)
        if (by[axis] != 0.0) to[axis] = position_mm_[axis] + by[axis];
      begin_move(to[0], to[1], to[2], speed, now, effects);
    };
  } else if (verb == "pulse" && v.size() == 2) {
    if (const auto why = pulses_refused(v)) return refuse(kLimit, *why, fx);
    s.begin = service_questions(verb, config_.table);
    s.then = [this, n = int(v[0]), pitch = v[1]](std::int64_t now, Effects& effects) {
      for (std::size_t axis = 0; axis < 2; ++axis)  // a row is planned for a place that can be
        if (auto why = limit_broken("XY"[axis], position_mm_[axis], limits_[axis]))
          return refuse(kLimit, *why, effects);
      GridSpec row;
      row.nx = n;
      row.ny = 1;
      row.pitch_x_mm = row.pitch_y_mm = pitch;
      row.origin_x_mm = position_mm_[0] + pitch;
      row.origin_y_mm = position_mm_[1];
      begin_pass(DropletPattern(row, 1), 0, kNaN, std::min(kStageJogSpeed_mm_s, pitch * kServicePulseRate_hz),
                 0.0, {}, now, effects);
    };
  } else if ((verb == "where" || verb == "params" || verb == "serial") && v.empty()) {
    s.begin = service_questions(verb, config_.table);
  } else {
    return Driver::service(verb, v, now_us, fx);
  }
  run_service(std::move(s));
}

bool Stage::accept(Op op, Effects& fx) {
  if (busy()) {
    refuse(kNoCode, "the stage is busy with another command", fx);
    return false;
  }
  if (op == Op::kHome && phase_ == Phase::kDead && link_.idle()) return true;  // the operator's reset
  if (phase_ != Phase::kReady) {
    refuse(kNoCode, std::string("the stage is ") + standing(), fx);
    return false;
  }
  return true;
}

void Stage::begin_pass(const DropletPattern& pattern, int pass, double z_mm, double speed_mm_s,
                       double lead_mm, const Placement& placement, std::int64_t now_us, Effects& fx) {
  if (!accept(Op::kPass, fx)) return;
  PassPlan plan;
  if (auto why = plan_pass(pattern, pass, z_mm, speed_mm_s, lead_mm, placement, plan))
    return refuse(why->code, std::move(why->text), fx);
  op_ = Op::kPass;
  start_mm_ = {kNaN, kNaN, z_mm};
  runs_ = std::move(plan.runs);
  expected_ = plan.expected;
  speed_mm_s_ = plan.speed_mm_s;
  if (runs_.empty()) return finish({Outcome::kDone, 0, 0, 0, 0, kNoCode, "no droplets in this pass"}, fx);
  start_operation(now_us, fx);
}

void Stage::begin_scan(double x_mm, double y_mm, double z_mm, double pitch_mm, int rows, double speed_mm_s,
                       std::int64_t now_us, Effects& fx) {
  if (!accept(Op::kScan, fx)) return;
  ScanPlan plan;
  if (auto why = plan_scan(x_mm, y_mm, z_mm, pitch_mm, rows, speed_mm_s, plan))
    return refuse(why->code, std::move(why->text), fx);
  op_ = Op::kScan;
  runs_.clear();
  expected_ = rows;
  speed_mm_s_ = plan.speed_mm_s;
  scan_pitch_mm_ = plan.pitch_mm;
  start_mm_ = {x_mm, y_mm - plan.pitch_mm, z_mm};
  start_operation(now_us, fx);
}

void Stage::begin_move(double x_mm, double y_mm, double z_mm, double speed_mm_s, std::int64_t now_us,
                       Effects& fx) {
  if (!accept(Op::kMove, fx)) return;
  const std::array<double, 3> target{x_mm, y_mm, z_mm};
  double speed = speed_mm_s;
  if (auto why = plan_move(target, speed)) return refuse(why->code, std::move(why->text), fx);
  op_ = Op::kMove;
  runs_.clear();
  expected_ = 0;
  speed_mm_s_ = speed;
  start_mm_ = target;
  if (std::ranges::all_of(target, [](double mm) { return std::isnan(mm); }))
    return finish({Outcome::kDone, -1, 0, 0, 0, kNoCode, "no axis to move"}, fx);
  start_operation(now_us, fx);
}

void Stage::begin_trace(StageWay way, double z_mm, std::int64_t now_us, Effects& fx) {
  if (!accept(Op::kTrace, fx)) return;
  if (const auto why = way_refused(way, limits_, config_, config_.table)) return refuse(kLimit, *why, fx);
  if (auto why = std::isnan(z_mm) ? std::nullopt : limit_broken('Z', z_mm, limits_[2]))
    return refuse(kLimit, *why, fx);
  op_ = Op::kTrace;
  runs_.clear();
  start_mm_ = {way.knots[0].x_mm, way.knots[0].y_mm, z_mm};
  expected_ = std::int64_t(way.switch_mm.size());
  way_ = std::move(way);
  start_operation(now_us, fx);
}

void Stage::begin_home(Effects& fx) {
  if (!accept(Op::kHome, fx)) return;
  op_ = Op::kHome;
  expected_ = 0;
  progress_ = {};
  ending_.clear();
  ending_code_ = kNoCode;
  doom_.reset();
  initialised_ = false;
  restarted_ = was_homed_ = false;
  set_state(DeviceState::kActive, "homing", fx);
  phase_ = Phase::kFaultCheck;
  axis_ = 0;
  asked_ = acknowledged_ = false;
}

void Stage::start_operation(std::int64_t now_us, Effects& fx) {
  progress_ = {};
  pulses_.reset();
  restarted_ = false;
  ending_.clear();
  ending_code_ = kNoCode;
  set_state(DeviceState::kActive,
            std::string(op_ == Op::kPass    ? "raster pass"
                        : op_ == Op::kScan  ? "scan"
                        : op_ == Op::kTrace ? "path"
                                            : "move"),
            fx);
  if (initialised_) return go_to_start(now_us);
  phase_ = Phase::kFaultCheck;  // a stop came before the axes were homed
  axis_ = 0;
  asked_ = acknowledged_ = false;
}

// Straight move from rest to rest; NaN = axis stays. Given once, never again.
void Stage::move(std::array<double, 3> target_mm, double speed_mm_s, std::int64_t now_us) {
  if (on(config_.absolute) && !absolute_) link_.push(Line(config_.table, Repeat::kSetup, kPlain).text("ABS"));
  absolute_ = true;
  Line line(config_.table, Repeat::kNever, kMotion);
  line.text("LINEAR");
  double squared = 0.0;
  for (std::size_t a = 0; a < 3; ++a) {
    target_mm_[a] = target_mm[a];
    if (std::isnan(target_mm[a])) continue;
    line.text(" ").axis(int(a)).text(" ").fixed4(target_mm[a]);
    const double d = std::isnan(position_mm_[a]) ? 0.0 : target_mm[a] - position_mm_[a];
    squared += d * d;
  }
  link_.push(line.text(" F").fixed4(speed_mm_s));
  const double plan_s = move_time_s(std::sqrt(squared), speed_mm_s, config_.acceleration_mm_s2);
  move_end_us_ = now_us + std::int64_t(plan_s * 1e6) + 1000;
  move_limit_us_ =
      now_us +
      std::int64_t((plan_s * config_.move_timeout_factor + 0.5 + 2.0 * config_.host_latency_s) * 1e6);
  poll_at_us_ = std::min(move_end_us_, now_us + std::int64_t(config_.poll_moving_s * 1e6));
  poll_ = Poll::kNone;
}

// Height for the work, or NaN where the nozzle already stands at it.
double Stage::z_target_mm() const {
  return std::abs(start_mm_[2] - position_mm_[2]) <= config_.dialect.tolerance_mm ? kNaN : start_mm_[2];
}

void Stage::go_to_start(std::int64_t now_us) {
  phase_ = Phase::kToStart;
  if (op_ == Op::kPass) {
    const RasterRun& run = runs_[progress_.run];
    move({run.start_x_mm, run.y_mm, z_target_mm()}, config_.move_speed_mm_s, now_us);
  } else {
    move({start_mm_[0], start_mm_[1], op_ == Op::kMove ? start_mm_[2] : z_target_mm()},
         op_ == Op::kMove ? speed_mm_s_ : config_.move_speed_mm_s, now_us);
    progress_.launched = op_ == Op::kMove;
  }
}

// Over only when the plane and then every axis says so; while the plane is busy the axes need not be asked.
Stage::Motion Stage::poll_motion(std::int64_t now_us) {
  const bool all = phase_ == Phase::kStopping;
  const auto concerned = [&](int axis) { return all || !std::isnan(target_mm_[std::size_t(axis)]); };
  bool moving = false;
  switch (poll_) {
    case Poll::kNone:
      if (now_us < poll_at_us_) return Motion::kWaiting;
      link_.push(Line(config_.table, Repeat::kRead, kPlane, ensemble::kValue).text("PLANESTATUS(0)"));
      poll_ = Poll::kPlane;
      return Motion::kAsked;
    case Poll::kPlane:
      if (plane_busy_) {
        moving = true;
        break;
      }
      for (int a = 0; a < 3; ++a)
        if (concerned(a)) read("AXISSTATUS(@)", a, kStatus);
      poll_ = Poll::kAxes;
      return Motion::kAsked;
    case Poll::kAxes:
      for (int a = 0; a < 3; ++a)
        moving =
            moving || (concerned(a) && (status_[std::size_t(a)] & (ensemble::kMoving | ensemble::kHoming)));
  }
  poll_ = Poll::kNone;
  if (!moving) return Motion::kOver;
  const std::int64_t soon = now_us + std::int64_t(config_.poll_end_s * 1e6);
  poll_at_us_ =
      std::clamp(move_end_us_, soon, std::max(soon, now_us + std::int64_t(config_.poll_moving_s * 1e6)));
  return Motion::kWaiting;
}

Violation Stage::off_target() const {
  for (std::size_t a = 0; a < 3; ++a) {
    if (std::isnan(target_mm_[a]) ||
        std::abs(position_mm_[a] - target_mm_[a]) <= config_.dialect.tolerance_mm)
      continue;
    char text[120];
    std::snprintf(text, sizeof text, "axis %c stands at %.4f mm instead of %.4f mm", kAxisNames[a],
                  position_mm_[a], target_mm_[a]);
    return {text,
            {std::abs(position_mm_[a] - target_mm_[a]), config_.dialect.tolerance_mm, "mm",
             "devices.stage.dialect.tolerance_mm"}};
  }
  return {};
}

void Stage::push_arming() {
  if (op_ == Op::kTrace) {
    outputs_.lend_to_way();
    push_way(way_, readout_.prepare(way_, config_.path_sample_s), config_, config_.table, link_);
  } else if (op_ == Op::kScan) {
    outputs_.arm_scan(pulse_axis(), scan_pitch_mm_, config_, config_.table, link_);
  } else {
    outputs_.arm_row(pulse_axis(), runs_[progress_.run].increments, config_, config_.table, link_);
  }
}

void Stage::fire(std::int64_t now_us) {
  phase_ = Phase::kFiring;
  progress_.launched = true;
  pulses_.reset();
  if (op_ == Op::kTrace) return follow(now_us);
  if (op_ == Op::kPass)
    move({runs_[progress_.run].end_x_mm, kNaN, kNaN}, runs_[progress_.run].speed_mm_s, now_us);
  else
    move({kNaN, start_mm_[1] + (double(expected_) + 0.5) * scan_pitch_mm_, kNaN}, speed_mm_s_, now_us);
}

void Stage::count_run(std::int64_t now_us, Effects& fx) {
  const std::int64_t n = op_ == Op::kPass ? std::int64_t(runs_[progress_.run].increments.size()) : expected_;
  if (config_.table.pulse_count.empty()) {  // no counter: the move that came to its end is the evidence
    if (const Violation off = off_target(); !off.empty()) {
      fault(Severity::kStop, kStall, "stage: " + off.text, fx, off.figure);
      return begin_stop(now_us, fx, off.text, kStall);
    }
    pulses_ = n;
  }
  if (!pulses_ || *pulses_ != n) {
    const std::string why =
        std::to_string(pulses_.value_or(-1)) + " pulses counted, " + std::to_string(n) + " commanded";
    fault(Severity::kStop, kPulseCount, "stage: " + why, fx, {double(pulses_.value_or(-1)), double(n)});
    return begin_stop(now_us, fx, why, kPulseCount);
  }
  if (op_ == Op::kScan || op_ == Op::kTrace) {
    set_state(DeviceState::kSafe, op_ == Op::kScan ? "scan done" : "path done", fx);
    phase_ = Phase::kReady;
    return finish({Outcome::kDone, n, n, 0, 0, kNoCode, {}}, fx);
  }
  progress_.before += n;
  progress_.launched = false;
  ++progress_.run;
  fx.events.emplace_back(Progress{std::int32_t(progress_.run), std::int32_t(runs_.size()), progress_.before});
  if (progress_.run < runs_.size()) return go_to_start(now_us);
  set_state(DeviceState::kSafe, "pass done", fx);
  phase_ = Phase::kReady;
  finish({Outcome::kDone, expected_, expected_, expected_, expected_, kNoCode, {}}, fx);
}

// Status says "no motion" before the servo has settled on its target. A controller that never reports it
// does not begin.
bool Stage::settled(std::int64_t now_us, Effects& fx) {
  if (phase_ == Phase::kArming) {
    if (!(config_.settle_s > 0.0)) return true;
    phase_ = Phase::kSettling;
    move_limit_us_ = now_us + std::int64_t((config_.settle_s + 2.0 * config_.host_latency_s) * 1e6);
    poll_at_us_ = now_us;
    asked_ = false;
  }
  if (!asked_) {
    if (now_us < poll_at_us_) return false;
    for (const int axis : {0, 1}) read("AXISSTATUS(@)", axis, kStatus);
    asked_ = true;
    return false;
  }
  if (status_[0] & status_[1] & ensemble::kInPosition) return true;
  if (now_us >= move_limit_us_) {
    const std::string why = std::string("axis ") + (status_[0] & ensemble::kInPosition ? "Y" : "X") +
                            " does not settle at the start of the path";
    fault(Severity::kStop, kStall, "stage: " + why, fx);
    begin_stop(now_us, fx, why, kStall);
    return false;
  }
  asked_ = false;
  poll_at_us_ = now_us + std::int64_t(kSettlePoll_s * 1e6);
  return false;
}

void Stage::follow(std::int64_t now_us) {
  readout_.begin(way_, now_us);
  link_.push(Line(config_.table, Repeat::kNever, kMotion).text(config_.dialect.path_program));
  const WayKnot& end = way_.knots.back();
  target_mm_ = {end.x_mm, end.y_mm, kNaN};
  move_end_us_ = now_us + std::int64_t(end.t_s * 1e6) + 1000;
  move_limit_us_ =
      now_us +
      std::int64_t((end.t_s * config_.move_timeout_factor + 0.5 + 2.0 * config_.host_latency_s) * 1e6);
  poll_at_us_ = std::min(move_end_us_, now_us + std::int64_t(config_.poll_moving_s * 1e6));
  poll_ = Poll::kNone;
}

// No question while the state of the motion is due: a stop is never behind them.
bool Stage::read_samples() {
  const auto question = readout_.question(poll_at_us_, config_, config_.table);
  if (question) link_.push(*question);
  return question.has_value();
}

// The same once the motion is over, until nothing is left.
bool Stage::read_last_samples() {
  poll_at_us_ = -1;
  return read_samples();
}

bool Stage::work(std::int64_t now_us, Effects& fx) {
  switch (phase_) {
    case Phase::kStopping:
    case Phase::kToStart:
    case Phase::kFiring: {
      const Motion motion = poll_motion(now_us);
      if (motion == Motion::kAsked) return true;
      if (motion == Motion::kWaiting) {
        if (now_us >= move_limit_us_ && phase_ == Phase::kStopping) {
          fault(Severity::kStop, kStall, "stage: it does not stop", fx);
          reconnect(now_us, fx, "it does not stop");
          return true;
        }
        if (now_us >= move_limit_us_) {
          fault(Severity::kStop, kStall, "stage: a move is not over in time", fx);
          begin_stop(now_us, fx, "a move was not over in time", kStall);
          return true;
        }
        return phase_ == Phase::kFiring && op_ == Op::kTrace && read_samples();
      }
      if (phase_ == Phase::kStopping) {
        phase_ = Phase::kEvidence;
        for (int a = 0; a < 3; ++a) read("PFBKPROG(@)", a, kPosition);
        for (int a = 0; a < 3; ++a) read("AXISFAULT(@)", a, kFaultBits);
        if (progress_.launched && (op_ == Op::kPass || op_ == Op::kScan || op_ == Op::kTrace) &&
            !config_.table.pulse_count.empty())
          read(config_.table.pulse_count, pulse_axis(), kCount);
      } else if (phase_ == Phase::kToStart) {
        phase_ = Phase::kAtStart;
        for (int a = 0; a < 3; ++a)
          if (!std::isnan(target_mm_[std::size_t(a)])) read("PFBKPROG(@)", a, kPosition);
      } else {
        phase_ = Phase::kCounting;
        const std::size_t axis = std::size_t(pulse_axis());
        position_mm_[axis] = target_mm_[axis];
        if (op_ == Op::kTrace) position_mm_[1] = target_mm_[1];
        setup("PSOCONTROL @", int(axis), " OFF");
        if (!config_.table.pulse_count.empty())
          read(config_.table.pulse_count, int(axis), kCount);
        else
          read("PFBKPROG(@)", int(axis), kPosition);
      }
      return true;
    }
    case Phase::kAtStart:
      if (const Violation off = off_target(); !off.empty()) {
        fault(Severity::kStop, kStall, "stage: " + off.text, fx, off.figure);
        begin_stop(now_us, fx, off.text, kStall);
      } else if (op_ == Op::kMove) {
        phase_ = Phase::kReady;
        set_state(DeviceState::kSafe, "move done", fx);
        finish({Outcome::kDone, -1, 0, 0, 0, kNoCode, {}}, fx);
      } else {
        phase_ = Phase::kArming;
        push_arming();
      }
      return true;
    case Phase::kArming:
    case Phase::kSettling:
      if (op_ == Op::kTrace && !settled(now_us, fx)) return !link_.idle();
      fire(now_us);
      return true;
    case Phase::kCounting:
      if (op_ == Op::kTrace && read_last_samples()) return true;
      count_run(now_us, fx);
      return true;
    default:
      return false;
  }
}

}  // namespace firn::drivers
