// LineJudge measures the true lines of a print, layer by layer, as no node can, and sums up what the camera
// saw.
#pragma once

#include <cmath>
#include <vector>

#include "config/experiment.h"
#include "core/path/line_stations.h"
#include "firn/line_plan_t.hpp"
#include "firn/path_report_t.hpp"
#include "runtime/node.h"

namespace firn {

/// Sections, heights and widths are of all layers, about those of the nominal surface, over the stations that
/// can be read; ends are of single layers, from the third on (of the last, where there are fewer).
struct LineTruth {
  int stations = 0;
  double section_rms = 0.0, section_mean = 0.0, section_std = 0.0;  ///< relative
  double height_rms = 0.0;                                          ///< relative
  double width_rms_mm = 0.0, width_mean_mm = 0.0;                   ///< mean: of the line's width
  /// As the camera would see it without blur: full width at half contrast, about the nominal surface's.
  double visible_rms_mm = 0.0;
  double offset_rms_mm = 0.0;  ///< of the middle from the wanted line
  double overspray = 0.0;
  double worst_start_mm = 0.0, worst_end_mm = 0.0;  ///< largest absolute value of any free end
  double gaps = 0.0;                                ///< stations with less than 0.3 of the nominal section
};

/// The lines after the last layer as LINE_PLAN has them from the camera's pictures; NaN: without a camera.
struct LineLooks {
  int stations = 0;
  double width_rms_mm = NAN;   ///< of the width at half contrast about the nominal line's
  double offset_rms_mm = NAN;  ///< of the middle from the wanted line
  double overspray = NAN;
  double gap_mm = NAN;  ///< length without material
};

/// The stage's paths by their position feedback, over all layers; NaN: none was recorded.
struct LinePaths {
  int layers = 0;
  double contour_max_mm = NAN, contour_rms_mm = NAN;  ///< from the planned path
  double following_max_mm = NAN;                      ///< from the place of the same time
  double lag_max_s = NAN;
  double switch_max_mm = NAN;  ///< of a switch, along the path
  double offset_rms_mm = NAN;  ///< of the lines' middles from the wanted ones
};

class LineJudge {
 public:
  LineJudge(const Experiment& experiment, const Blobs& inputs);
  int layer() const { return layer_; }
  void take(int layer, const HeightMap& surface);
  void take(const line_plan_t& plan);
  void take(const path_report_t& report);
  LineTruth result() const;
  const LineLooks& looks() const { return looks_; }
  const LinePaths& paths() const { return paths_; }

 private:
  std::vector<LineStation> stations_;
  std::vector<LineEnd> ends_;
  double width_mm_, optical_depth_mm_, believed_depth_mm_;
  std::vector<double> layer_mm2_;  ///< nominal section of one layer, by station
  LineLooks looks_;
  LinePaths paths_;
  HeightMap target_, before_, newest_;
  int layer_ = 0, wanted_layers_;
  double worst_start_mm_ = 0.0, worst_end_mm_ = 0.0;
};

}  // namespace firn
