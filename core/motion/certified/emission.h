// emit() computes the trajectory of planned segments: samples at the tick, certificate, trace.
#pragma once

#include <span>

#include "core/motion/certified/path_part.h"
#include "core/motion/certified/stop_segment.h"

namespace firn::motion {

/// Buffers kept between paths.
struct EmissionWork {
  StateBatch batch;
  Jets tool, joint, flange;
};

/// Slows the motion down to whole ticks, and until no sample and no difference of samples exceeds a limit.
/// @pre the ratios of the segments are bounds at every instant
void emit(const PathInput& input, const CertifiedTask& task, std::span<const StopSegment> segments,
          EmissionWork& work, PlanResult& result);

}  // namespace firn::motion
