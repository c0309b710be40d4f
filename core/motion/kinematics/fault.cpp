#include "core/motion/kinematics/fault.h"

#include <cstdio>

namespace firn::motion {

const char* name(Reason reason) {
  switch (reason) {
    case Reason::kNotFinite:
      return "not finite";
    case Reason::kTooFewPoints:
      return "too few points";
    case Reason::kLimitNotPositive:
      return "limit not positive";
    case Reason::kSpeedLimitNotPositive:
      return "speed ceiling not positive";
    case Reason::kSpeedLimitSize:
      return "speed ceiling of the wrong size";
    case Reason::kYawSize:
      return "yaws of the wrong size";
    case Reason::kYawJump:
      return "yaw turns on the spot";
    case Reason::kOption:
      return "option out of range";
    case Reason::kReachFar:
      return "reach far";
    case Reason::kReachNear:
      return "reach near";
    case Reason::kSingular:
      return "singular";
    case Reason::kJointLow:
      return "joint low";
    case Reason::kJointHigh:
      return "joint high";
    case Reason::kDespin:
      return "despin";
    case Reason::kTooLong:
      return "too long";
    case Reason::kNoSolution:
      return "no solution";
    case Reason::kPathDeviation:
      return "the curve leaves the path [mm]";
  }
  return "unknown";
}

std::string describe(const Fault& f) {
  std::string text = name(f.reason);
  if (!f.what.empty()) text += " (" + f.what + ")";
  if (f.axis >= 0) text += ", joint " + std::to_string(f.axis + 1);
  char numbers[160];
  std::snprintf(numbers, sizeof numbers, " at point %zu (%.6g, %.6g): %.9g, limit %.9g", f.index, f.at.x_mm,
                f.at.y_mm, f.value, f.bound);
  return text + numbers;
}

}  // namespace firn::motion
