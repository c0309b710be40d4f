// plan_by_descent() plans a segment along a spline inside the tube that descent of the time moves there: fits
// of several radii are starts, and the multipliers of the speed profile's limits are the gradient of the
// minimum time with regard to the curve.
#pragma once

#include <vector>

#include "core/motion/certified/segment_curve.h"
#include "core/motion/certified/speed_planner.h"

namespace firn::motion {

/// Buffers kept between paths.
struct DescentWork {
  StopSegment trial;
  std::vector<StretchBeyond> beyond;  ///< of a curve that left the tolerance
  std::vector<double> weight;         ///< of a step
};

/// Plans within the tolerance, or within the points' rounding. out.first and out.last are set.
void plan_by_descent(const PathPart& part, const CertifiedTask& task, SegmentCurve& curve,
                     SpeedPlanner& speed, DescentWork& work, StopSegment& out);

}  // namespace firn::motion
