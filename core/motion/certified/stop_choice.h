// plan_segments() decides where a path comes to rest, and plans the motions between.
#pragma once

#include <vector>

#include "core/motion/certified/shape_choice.h"

namespace firn::motion {

/// Buffers kept between paths.
struct StopWork {
  SegmentWork segment;
  std::vector<StopSegment> segments, candidate;
  StopSegment corner_trial;
};

/// Splits a path and plans all its segments into work.segments[0 .. result - 1]; with a tolerance, corners
/// are rolled where that is faster. Throws MotionError where no motion was found.
/// @param max_s without a tolerance: 0 segments where the path takes longer
std::size_t plan_segments(const CleanPath& path, const CertifiedTask& task, StopWork& work,
                          double max_s = kNoMaxDuration_s);

}  // namespace firn::motion
