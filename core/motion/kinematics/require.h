// require() throws the MotionError of an option or limit outside its range.
#pragma once

#include <cmath>
#include <string>
#include <string_view>

#include "core/motion/kinematics/fault.h"

namespace firn::motion {

/// @throws MotionError naming `what`, its value and the bound, unless good. @param axis 0-based, -1 = none
inline void require(bool good, Reason reason, std::string_view what, double value, double bound = 0.0,
                    int axis = -1) {
  if (good) return;
  Fault fault(reason);
  fault.axis = axis;
  fault.value = value;
  fault.bound = bound;
  fault.what = what;
  throw MotionError(fault);
}

/// @throws MotionError of an option that is not above 0 and finite
inline void require_positive(double value, std::string_view what) {
  require(value > 0.0 && std::isfinite(value), Reason::kOption, what, value);
}

}  // namespace firn::motion
