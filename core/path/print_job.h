// PrintJob holds the job of a shuttered printer: straight segments in order, each with its speed, and the
// nozzle's start and end [Thompson 2014, V-A].
#pragma once

#include <vector>

#include "core/path/path.h"

namespace firn {

/// Deposited from `from` to `to`, in the frame of the part.
struct PrintSegment {
  Point2 from, to;
  double speed_mm_s = 0.0;  ///< v_desired
};

/// n segments, 2n points, n speeds. Where one segment ends and the next begins at the same point the shutter
/// may stay open.
struct PrintJob {
  Point2 start, end;  ///< p_start, p_end: at rest, shutter closed
  std::vector<PrintSegment> segments;
};

/// The nozzle deposits from open_s to close_s; these are the times of the effect, not of the shutter's
/// commands.
struct ShutterSpan {
  double open_s = 0.0;
  double close_s = 0.0;
  bool operator==(const ShutterSpan&) const = default;
};

}  // namespace firn
