// emitted_ratio() is the continuous checker's largest ratio to a limit of the Cobra 600, of a motion as it is
// emitted: in whole ticks.
#pragma once

#include <algorithm>

#include "core/motion/certified/certified.h"
#include "tests/core/motion/continuous_checker.h"

namespace firn::motion {

/// @param work of the plan that made `result`
inline double emitted_ratio(const PlanResult& result, const CertifiedWork& work) {
  static const MotionLimits limits = cobra600_limits();
  const double slow = result.trajectory.certificate.duration_s / result.continuous_s;
  double most = 0.0;
  for (std::size_t k = 0; k <= result.stops; ++k) {
    StopSegment segment = work.segments()[k];
    segment.factor *= slow;
    for (const auto& row :
         ContinuousChecker(segment, limits, 325.0, 275.0, result.configuration.elbow).ratios(1e-3, 1.0))
      for (const double r : row) most = std::max(most, r);
  }
  return most;
}

}  // namespace firn::motion
