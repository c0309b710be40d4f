// swath_shifts_mm places the swaths in which a profiler's line that is shorter than the grid, or a point,
// scans it.
#pragma once

#include <vector>

#include "config/experiment.h"

namespace firn {

/// Cells that two swaths side by side have in common.
inline constexpr int kSwathOverlap = 2;
inline constexpr int kMaxSwaths = 64;

/// Returns the stage's x of each swath, from the grid's middle, from left to right; {0} where one is enough.
/// Swaths are of equal distance and overlap by kSwathOverlap cells at least; of a point that is moved each
/// column of the grid is one.
/// @throws std::invalid_argument: more than kMaxSwaths, or a line no longer than the overlap
std::vector<double> swath_shifts_mm(const Experiment& experiment);

}  // namespace firn
