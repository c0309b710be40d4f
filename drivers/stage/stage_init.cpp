// Stage: from a fresh connection, or after a fault, to enabled and homed axes.
#include "drivers/stage/stage.h"

namespace firn::drivers {
namespace {

constexpr char kAxisNames[] = "XYZ";
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
        fault(0, kAxisFault,
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
        if (!(status_[a] & ensemble::kEnabled)) {
          const std::string why = std::string("axis ") + kAxisNames[a] + " does not enable";
          doom_ = Doom{DriverState::kFault, kAxisFault, why};
          begin_stop(now_us, fx, why, kAxisFault);
          return true;
        }
      phase_ = Phase::kHoming;
      axis_ = 0;
      asked_ = false;
      return home_next(now_us, fx);
    case Phase::kHoming:
      return home_next(now_us, fx);
    case Phase::kRamp:
      if (!asked_) {
        for (int a = 0; a < 3; ++a) setup("RAMP MODE @", a, " RATE");
        link_.push(Line(config_.table, Repeat::kSetup, kPlain)
                       .text("RAMP RATE ")
                       .fixed4(config_.acceleration_mm_s2));
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
      set_state(DriverState::kSafe, initialised_ ? "homed" : "not homed", fx);
      if (op_ == Op::kHome)
        finish({Outcome::kDone, -1, 0, 0, 0, kNoCode, "homed"}, fx);
      else if (busy())
        finish({Outcome::kRefused, -1, expected_, 0, 0, kLimit, "the stage is not homed"}, fx);
      return false;
    default:
      return false;
  }
}

// One axis after the other, Z first. HOME may not be abortable over ASCII, so it is given once and then only
// watched.
bool Stage::home_next(std::int64_t now_us, Effects& fx) {
  for (; axis_ < 3; ++axis_, asked_ = false) {
    const int axis = kHomingOrder[axis_];
    const std::uint32_t bits = status_[std::size_t(axis)];
    if (!asked_) {
      const bool homed = bits & ensemble::kHomed;
      if (op_ == Op::kHome ? false : homed || !config_.home_at_start) continue;
      Line line(config_.table, Repeat::kNever, kMotion);
      link_.push(with_axis(line, config_.table.home, axis));
      read("AXISSTATUS(@)", axis, kStatus);
      poll_at_us_ = now_us;
      move_limit_us_ = now_us + std::int64_t(config_.home_timeout_s * 1e6);
      asked_ = true;
      progress_.launched = true;
      return true;
    }
    if (bits & ensemble::kHomed && !(bits & (ensemble::kMoving | ensemble::kHoming))) continue;
    if (now_us >= move_limit_us_) {
      const std::string why = std::string("axis ") + kAxisNames[axis] + " is not home in time";
      doom_ = Doom{DriverState::kFault, kStall, why};
      begin_stop(now_us, fx, why, kStall);
      return true;
    }
    if (now_us < poll_at_us_) return false;
    poll_at_us_ = now_us + std::int64_t(config_.poll_moving_s * 1e6);
    read("AXISSTATUS(@)", axis, kStatus);
    return true;
  }
  phase_ = Phase::kRamp;
  asked_ = false;
  return initialise(now_us, fx);
}

}  // namespace firn::drivers
