// LineOverlap holds two segments of a print job of which one lies on the other: a line printed twice.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/path/print_job.h"

namespace firn {

struct LineOverlap {
  std::int32_t first = 0, second = 0;  ///< segments, 0-based; first < second
  double length_mm = 0.0;              ///< of the stretch that is printed twice
};

/// Lines this near to each other are the same line: far below the width of any line of the lab.
inline constexpr double kSameLine_mm = 0.01;

/// Returns the pairs of segments that lie within kSameLine_mm of each other along 1 mm or half of the shorter
/// one, by first and second. Lines that cross, touch or run side by side are none.
/// @pre segments have a length
std::vector<LineOverlap> line_overlaps(const PrintJob& job);

/// Returns "segments[2] lies on segments[0] along 5 mm: …" for the first few pairs, then how many more.
std::vector<std::string> overlap_remarks(const PrintJob& job);

}  // namespace firn
