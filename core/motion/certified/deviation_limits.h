// Computes from PlanOptions by how much a curve may deviate from its path and from held points.
#pragma once

#include <algorithm>

#include "core/motion/certified/stop_segment.h"
#include "core/motion/curve/curve_pieces.h"
#include "core/motion/trajectory/plan.h"

namespace firn::motion {

/// Returns true if the curve may leave the points for the sake of a shorter time.
inline bool moves_within_tolerance(const PlanOptions& options) {
  return options.tolerance_mm > 0.0 && options.slack == 0.0;
}

/// Maximum deviation of any curve from its path: tolerance, + w / 2 by ramps and rounded corners, + sagitta
/// of the chords.
inline double max_deviation_mm(const PlanOptions& options) {
  return options.tolerance_mm + 0.5 * options.curvature_ramp_mm + kSagittaMm;
}

/// Maximum deviation of a fitted curve: the tolerance. Without one the held points bind first.
inline double allowed_deviation_mm(const PlanOptions& options) {
  return options.tolerance_mm > 0.0 ? options.tolerance_mm : max_deviation_mm(options);
}

/// Radius of the tube about the points: the tolerance, or the distance by which rounding of both coordinates
/// moves a point.
inline double fit_radius_mm(const PlanOptions& options) {
  return options.tolerance_mm > 0.0 ? options.tolerance_mm : kDiagonal * options.point_noise_mm;
}

/// Distance within which the curve passes every point; 0 = points are not held.
inline double hold_mm(const PlanOptions& options) {
  if (options.point_rule != PointRule::kHeld || options.tolerance_mm > 0.0) return 0.0;
  return std::max(fit_radius_mm(options), PlanOptions::kMinHold_mm);
}

/// Maximum distance between a curve and the polygon of its samples, where these are far apart.
inline double max_between_mm(const PlanOptions& options) { return kBetweenShare * max_deviation_mm(options); }

/// Returns true if the curve passes all held points.
inline bool holds(const StopSegment& segment, const PlanOptions& options) {
  const double within = hold_mm(options);
  return !(within > 0.0) || segment.points_off_mm <= within;
}

/// Returns true if the curve is within the tolerance.
inline bool inside_tolerance(const StopSegment& segment, const PlanOptions& options) {
  return segment.deviation_mm <= options.tolerance_mm;
}

/// Throws MotionError (kPathDeviation: value and bound in mm, index that of the clean path) for a curve that
/// is further off than max_deviation_mm(). It gets no certificate.
inline void require_near(const StopSegment& segment, const PlanOptions& options) {
  if (segment.deviation_mm <= max_deviation_mm(options)) return;
  Fault fault(Reason::kPathDeviation);
  fault.index = segment.first;
  fault.value = segment.deviation_mm;
  fault.bound = max_deviation_mm(options);
  throw MotionError(fault);
}

}  // namespace firn::motion
