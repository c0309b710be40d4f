// sampled_trace() computes the trace of a method that has only samples.
#pragma once

#include <span>
#include <vector>

#include "core/motion/trajectory/plan.h"

namespace firn::motion {

/// One entry per sample, by differences over the samples with rest before the start and after the end: rate
/// over the two ticks around it, acceleration over the same three samples, jerk of the tick after it.
/// @param tool tool position of each sample
std::vector<TraceSample> sampled_trace(const Trajectory& trajectory, std::span<const Point2> tool);

}  // namespace firn::motion
