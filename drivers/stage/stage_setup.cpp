// Stage: enabling, the controller's parameters, homing, ramps.
#include <cmath>
#include <cstdio>

#include "drivers/stage/stage.h"

namespace firn::drivers {
namespace {

constexpr int kPollsToBegin = 3;
constexpr int kHomingOrder[] = {2, 0, 1};  // the nozzle goes up first

}  // namespace

using ensemble::Line;

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

// Before anything moves: a wrong number of counts per mm moves an axis to a wrong place at a wrong speed.
bool Stage::check_parameters(std::int64_t now_us, Effects& fx) {
  if (on(config_.check_parameters) && !asked_) {
    const auto ask = [&](int axis, ensemble::Parameter parameter) {
      Line line(config_.table, Repeat::kRead, kParameter, ensemble::kValue);
      Request r = line.text("GETPARM(").axis(axis).text(", ").integer(parameter).text(")").done();
      r.argument = 3 * parameter + axis;
      link_.push(r);
    };
    for (int axis = 0; axis < 3; ++axis)
      for (const auto parameter : {ensemble::kCountsPerUnit, ensemble::kSoftwareLimitLow,
                                   ensemble::kSoftwareLimitHigh, ensemble::kSoftwareLimitSetup})
        ask(axis, parameter);
    ask(0, ensemble::kGlobalIntegers);
    return asked_ = true;
  }
  if (on(config_.check_parameters)) {
    if (const auto why = parameter_mismatch()) return give_up(DeviceState::kFault, kLimit, *why, now_us, fx);
    config_.table.iglobals = global_integers_;
    increments_held_.resize(std::size_t(config_.table.increments()), -1);
  }
  phase_ = Phase::kHoming;
  axis_ = 0;
  asked_ = false;
  return home_next(now_us, fx);
}

std::optional<std::string> Stage::parameter_mismatch() const {
  char text[200];
  for (std::size_t a = 0; a < 3; ++a) {
    const AxisParameters& p = parameters_[a];
    const char axis = kAxisNames[a], key = char(axis - 'A' + 'a');
    if (!(std::abs(p.counts_per_unit - config_.counts_per_mm) <= 1e-6 * config_.counts_per_mm)) {
      std::snprintf(text, sizeof text, "axis %c: CountsPerUnit is %g, stage.counts_per_mm is %g", axis,
                    p.counts_per_unit, config_.counts_per_mm);
      return text;
    }
    if (p.limit_setup == 0.0) {
      std::snprintf(text, sizeof text, "axis %c: the controller's soft limits are off (SoftwareLimitSetup)",
                    axis);
      return text;
    }
    constexpr double kRounding_mm = 1e-4;
    if (!(p.low_limit_mm <= limits_[a].min_mm + kRounding_mm &&
          p.high_limit_mm >= limits_[a].max_mm - kRounding_mm)) {
      std::snprintf(text, sizeof text,
                    "axis %c: the controller's soft limits [%g, %g] mm are inside stage.%c_min_mm, "
                    "stage.%c_max_mm [%g, %g] mm",
                    axis, p.low_limit_mm, p.high_limit_mm, key, key, limits_[a].min_mm, limits_[a].max_mm);
      return text;
    }
  }
  if (global_integers_ <= config_.first_iglobal) {
    std::snprintf(text, sizeof text,
                  "GlobalIntegers is %d: none is left for firing distances from stage.first_iglobal = %d",
                  global_integers_, config_.first_iglobal);
    return text;
  }
  return std::nullopt;
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
