// Computes the certificate of a trajectory for all planners: ratios to the limits by differences of the
// emitted samples and, where the continuous motion is known, by that motion itself.
#pragma once

#include <span>
#include <vector>

#include "core/motion/kinematics/arm.h"
#include "core/motion/kinematics/limits.h"
#include "core/motion/time_optimal/motion_samples.h"
#include "core/path/path.h"

namespace firn::motion {

/// Ratios by differences over the samples of a trajectory, as anybody can form them from its file:
/// rate (q[n+1] - q[n]) / h, acceleration (q[n+1] - 2 q[n] + q[n-1]) / h^2, jerk (q[n+2] - 3 q[n+1] + 3 q[n]
/// - q[n-1]) / h^3, with rest (the end samples repeated) before the start and after the end. A difference is
/// a weighted mean of the derivative over the ticks it spans, so no difference can exceed the largest value
/// of a motion that is smooth enough to have one.
/// @param tool tool position of each sample; @param yaw_rad its yaw, empty = constant
RatioTable difference_ratios(const Trajectory& trajectory, std::span<const Point2> tool,
                             std::span<const double> yaw_rad, const RowGroups& groups);

/// "total speed", "J2 jerk", … for the limits that are finite, with their ratios.
void fill_certificate(const RatioTable& table, const RowGroups& groups, const Arm& arm,
                      Certificate& certificate);

}  // namespace firn::motion
