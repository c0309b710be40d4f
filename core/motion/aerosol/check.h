// Checks a job and a machine before planning.
#pragma once

#include <vector>

#include "core/motion/aerosol/plan.h"

namespace firn::motion {

/// Within 1e-6 mm: rounding of a file, far below the resolution of any stage.
bool coincide(const Point2& a, const Point2& b);

/// @throws MotionError (kLimitNotPositive, kOption) naming the quantity
void check_machine(const AerosolMachine& machine, const AerosolOptions& options);

/// Segments that no planner can do: not finite, without length, without speed, faster than an axis, outside
/// the range.
std::vector<Refusal> check_job(const PrintJob& job, const AerosolMachine& machine);

/// "%.*f" without trailing zeros
std::string text(double value, int decimals = 4);

}  // namespace firn::motion
