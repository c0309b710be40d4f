// Fault holds the reason why a path cannot be planned, with the point, the value and the limit that it
// exceeds.
#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>

#include "core/path/path.h"

namespace firn::motion {

enum class Reason {
  kNotFinite,         ///< a coordinate, speed or option is NaN or infinite
  kTooFewPoints,      ///< fewer than two distinct points
  kLimitNotPositive,  ///< a kinematic limit or the tick is zero, negative or NaN
  kSpeedLimitNotPositive,
  kYawSize,         ///< the yaws do not have one entry per point
  kYawJump,         ///< the yaw changes where the tool stays: a turn on the spot is no path
  kSpeedLimitSize,  ///< the per-point speed limit does not have one entry per point
  kOption,          ///< a planner option outside its range
  kReachFar,        ///< beyond the stretched arm
  kReachNear,       ///< inside the folded arm
  kSingular,        ///< arm stretched or folded: joint rates have no bound
  kJointLow,        ///< below a joint's range
  kJointHigh,       ///< above a joint's range
  kDespin,          ///< the wrist joint would need more than its whole range on one path
  kTooLong,         ///< more points or samples than kMaxSamples
  kNoSolution,      ///< no trajectory obeys the limits
  kPathDeviation,   ///< the curve found leaves the path by more than ramps and rounded corners can explain
};

/// "reach far", "joint high", …
const char* name(Reason reason);

struct Fault {
  explicit Fault(Reason why = Reason::kNoSolution) : reason(why) {}

  Reason reason;
  std::size_t index = 0;  ///< point of the input path (0-based), or entry of the faulty table
  int axis = -1;          ///< 0-based joint, -1 = none
  double value = 0.0;     ///< in the unit of the limit: mm, rad, mm/s, …
  double bound = 0.0;
  Point2 at;         ///< where, in the frame of the path handed in
  std::string what;  ///< the name of the limit or option, when it has one
};

/// One sentence with all of the above.
std::string describe(const Fault& fault);

/// The only exception that core/motion throws.
class MotionError : public std::runtime_error {
 public:
  explicit MotionError(Fault fault) : std::runtime_error(describe(fault)), fault_(std::move(fault)) {}
  const Fault& fault() const { return fault_; }

 private:
  Fault fault_;
};

}  // namespace firn::motion
