// measure_line(), measure_end() and measure_added_end() measure printed lines in a picture on a grid: a
// height map, or a grey picture whose values grow with the material.
#pragma once

#include <optional>

#include "core/grid/grid.h"
#include "core/path/line_stations.h"

namespace firn::vision {

/// The part of a picture around a station or an end that is read.
struct LineWindow {
  double half_window_mm = 0.25;  ///< of a section to either side, less where another line is near
  double min_room_mm = 0.1;      ///< a station with less of it is not read
  double min_share = 0.6;        ///< of a section's samples that must be measured
  double noise_mm = 0.0;         ///< of one cell; a section lower than 4 / sqrt(samples) of it has no width
  double end_before_mm = 0.5;    ///< read outside an end
  double end_inside_mm = 1.2;    ///< and inside; the last half of it is the line's level
};

/// The mean section of a station. Width and middle are those of half the largest height; overspray is what
/// lies more than 1.3 widths from the middle (of a Gauss curve 0.2 %). Returns nothing where too little is
/// measured; width, offset and overspray are NaN where there is no line.
std::optional<LineReading> measure_line(const HeightMap& picture, const LineStation& station,
                                        const LineWindow& window);

/// Picture of a smooth surface seen through a window that has these extents, to second order.
HeightMap seen_through(const HeightMap& picture, double extent_x_mm, double extent_y_mm);

/// Length by which a line begins later than planned, or ends farther than planned [mm]: where the level
/// of the line's middle crosses half of its level inside. Returns nothing for an end that is not free or too
/// short, or that cannot be seen.
std::optional<double> measure_end(const HeightMap& picture, const LineEnd& end, double width_mm,
                                  const LineWindow& window);

/// Level of the line's middle inside an end, over the last half of end_inside_mm. Returns nothing within the
/// noise.
std::optional<double> level_inside(const HeightMap& picture, const LineEnd& end, double width_mm,
                                   const LineWindow& window);

/// Ink around an end before and after a layer.
struct AddedInk {
  const HeightMap& before;
  const HeightMap& after;
  double level = 0.0;    ///< that the layer adds to the line's middle
  double deepest = 0.0;  ///< of all layers; of more ink a picture does not tell how much it is
};

/// measure_end() of the ink that one layer added: where this first comes up to half of its level, from
/// outside. Returns nothing where all ink is deeper there.
std::optional<double> measure_added_end(const AddedInk& ink, const LineEnd& end, double width_mm,
                                        const LineWindow& window);

}  // namespace firn::vision
