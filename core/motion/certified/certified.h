// plan_certified() computes the motions of methods `certified` and `optimal`: for each segment between stops
// the minimum-time motion within all limits on its curve, proved at every instant
// (docs/algorithms/certified-motion.md).
//
//   path_corners      corners of the path
//   stop_choice       corners that are rolled, stops where no curve is inside the tolerance
//   shape_choice      of each segment the shape that is fastest
//   segment_curve     the curve of one shape, within the deviation allowed
//   curve_descent     a fitted curve that is moved inside its tube as long as that saves time
//   speed_planner     the minimum-time motion along a curve, and its proof
//   emission          samples at the tick, certificate, trace
#pragma once

#include "core/motion/certified/emission.h"
#include "core/motion/certified/stop_choice.h"

namespace firn::motion {

/// Everything that one planner thread reuses from path to path.
struct CertifiedWork {
  StopWork stops;
  EmissionWork emission;
  /// Segments of the last path; those of longer paths before it may follow.
  const std::vector<StopSegment>& segments() const { return stops.segments; }
};

/// Plans a whole path by options.point_rule, but for kFaster. Throws MotionError, with Fault::at in the
/// input's frame.
PlanResult plan_certified(const PathInput& input, const Arm& arm, const MotionLimits& limits,
                          const PlanOptions& options, CertifiedWork& work);

/// The same without a tolerance by PointRule::kFaster: the faster of the two curves, of equally fast ones the
/// one that holds the points. The other one is planned only as far as it may be faster.
PlanResult plan_faster(const PathInput& input, const Arm& arm, const MotionLimits& limits,
                       PlanOptions options, CertifiedWork& work);

}  // namespace firn::motion
