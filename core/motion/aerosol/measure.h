// measure() computes the errors of a plan while the shutter is open, and its ratios to the stage's limits.
#pragma once

#include <functional>

#include "core/motion/aerosol/plan.h"

namespace firn::motion {

/// Position and velocity at `dt_s` after the piece's begin.
PlaneState state_of(const Piece& piece, double dt_s);

/// Largest value of a smooth f over [0, duration] and where: exact at the ends, within about 1e-9 of the
/// largest inside.
struct Peak {
  double at = 0.0, value = 0.0;
};
Peak largest(const std::function<double(double)>& f, double duration);

/// Where and when the constant-speed print of one segment begins; the reference of the position error.
struct PrintStart {
  double t_s = 0.0;
  Point2 p_mm;
};

/// Fills the report's errors and ratios from the pieces. @param starts one per segment
void measure(const PrintJob& job, const AerosolMachine& machine, const std::vector<PrintStart>& starts,
             AerosolPlan& plan);

}  // namespace firn::motion
