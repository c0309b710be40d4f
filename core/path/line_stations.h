// LineStation and LineEnd are the places of a print job at which its lines are measured and steered:
// stretches of the segments, and the begins and ends of strokes that lie free.
#pragma once

#include <cstdint>
#include <vector>

#include "core/path/print_job.h"

namespace firn {

/// A stretch of one segment, about as long as all others.
struct LineStation {
  std::int32_t segment = 0;           ///< 0-based
  double from_mm = 0.0, to_mm = 0.0;  ///< along the segment
  Point2 at;                          ///< its middle
  Point2 direction;                   ///< unit vector of travel
  std::int32_t line = 0;  ///< joined segments that turn by less than 30 degrees from one to the next
  double room_mm = 1e9;   ///< from the stretch to the next line of another stroke or around a corner
};

/// Divides every segment into whole stretches of at most about spacing_mm. @pre segments have a length
std::vector<LineStation> line_stations(const PrintJob& job, double spacing_mm);

/// Beginning or end of a stroke. Segments that meet belong to one stroke.
struct LineEnd {
  std::int32_t segment = 0;
  bool start = true;
  Point2 at;
  Point2 direction;        ///< unit vector of travel
  bool free = true;        ///< no other line within the clearance
  double length_mm = 0.0;  ///< of its segment
};
std::vector<LineEnd> line_ends(const PrintJob& job, double clearance_mm);

/// Distance from a point to a segment.
double distance_to(const Point2& p, const PrintSegment& s);

/// A measured station. NaN: not known.
struct LineReading {
  double area_mm2 = 0.0;   ///< cross-section
  double width_mm = 0.0;   ///< full width at half height
  double offset_mm = 0.0;  ///< middle of the line, > 0 to the left of its direction
  double height_mm = 0.0;  ///< largest height of the mean section
  double overspray = 0.0;  ///< share of the cross-section beside the line
};

}  // namespace firn
