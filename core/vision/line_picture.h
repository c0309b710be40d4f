// measure_line_picture() measures a printed line in a camera's picture from above: edges, width, gaps and
// overspray, each with its standard deviation. Samples, profiles and robust fits are own code: OpenCV has no
// median, mean or fit that leaves out pixels (core/vision/raster.h).
#pragma once

#include <span>
#include <vector>

#include "core/vision/frame.h"

namespace firn::vision {

/// The wanted line in a picture. Across it, distances grow to the left of the direction as the picture shows
/// it.
struct LineView {
  Point middle;              ///< of the stretch [px]
  Point direction{1, 0};     ///< unit vector of travel
  double length_px = 0.0;    ///< of the stretch; parts beside the picture are not read
  double width_px = 20.0;    ///< expected, at half contrast
  double window_px = 100.0;  ///< read to either side: at most half of the room to the next line
};

struct LinePictureOptions {
  double search_px = 25.0;   ///< largest distance of the line from the wanted one
  double blur_px = 1.0;      ///< standard deviation of the optics' point spread function, by a knife edge
  double blur_std_px = 0.1;  ///< of this number
};

/// A stretch without material, in px from the beginning of the stretch.
struct LineGap {
  double from_px = 0.0, to_px = 0.0;
  double std_px = 0.0;  ///< of each
};

/// Contrast is the share of the ground's light that the line lacks, or adds where it is brighter.
/// Edges lie where the contrast is half of that of the line's middle.
struct LinePictureReading {
  bool seen = false;                          ///< false: no line within the search; only gaps may be said
  double left_px = 0.0, left_std_px = 0.0;    ///< across from the wanted line
  double right_px = 0.0, right_std_px = 0.0;  ///< usually negative
  double width_px = 0.0, width_std_px = 0.0;
  double contrast = 0.0;                        ///< of the line's middle; negative: brighter than the ground
  double overspray = 0.0, overspray_std = 0.0;  ///< share of the contrast more than 1.3 widths away
  std::vector<LineGap> gaps;
  double read_px = 0.0;  ///< length of the stretch inside the picture
};

/// The light of the empty scene with the dirt on window and sensor: in each pixel the median of the pictures,
/// their brightness made equal. Empty where the pictures are none, not valid, or not alike in size.
Frame flat_field(std::span<const Frame* const> bare);

/// @param flat of the same size, or nullptr: the ground is then a quadric through both sides of the line
LinePictureReading measure_line_picture(const Frame& picture, const Frame* flat, const LineView& view,
                                        const LinePictureOptions& options = {});

}  // namespace firn::vision
