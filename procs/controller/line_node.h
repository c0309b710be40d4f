// LineControllerNode decides the way of each layer of lines: HEIGHT_MAP, CAMERA_FRAME, PATH_REPORT,
// OPERATOR_COMMAND -> LINE_PLAN.
#pragma once

#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "config/changes.h"
#include "config/experiment.h"
#include "config/machine.h"
#include "core/control/lines/line_controller.h"
#include "core/control/lines/line_growth.h"
#include "core/grid/grid.h"
#include "core/vision/line_picture.h"
#include "core/vision/lines.h"
#include "firn/camera_frame_t.hpp"
#include "firn/height_map_t.hpp"
#include "firn/line_plan_t.hpp"
#include "firn/operator_command_t.hpp"
#include "firn/path_report_t.hpp"
#include "runtime/node.h"

namespace firn {

/// Reads the lines in the map and in its difference to the map of the layer before, and asks LineController.
/// With a camera, the picture k of a layer shows station k - 1, and arrives before the map; those of layer 0
/// show the bare substrate and give the light. Without a profiler the last picture asks: those of the ends
/// follow the stations'. They show all layers at once: the ends that tell the delays are those of the ink
/// that is new since the picture of the layer before, as long as it is not too dark there. An end behind
/// which the line goes on, or a layer after which the lines have not grown, stops the print, once.
class LineControllerNode final : public Node {
 public:
  /// @throws std::invalid_argument: a job that the machine cannot print
  LineControllerNode(const Experiment& experiment, const Machine& machine, PrintJob job,
                     const HeightMap& target);

  void on(const height_map_t&, Time now, Outbox&);
  void on(const camera_frame_t&, Time now, Outbox&);
  void on(const path_report_t&, Time now, Outbox&);
  void on(const operator_command_t&, Time now, Outbox&);

 private:
  /// Sends the plan with the decision of `decide`.
  void answer(line_plan_t plan, const std::function<control::LineDecision(line_plan_t&)>& decide, Outbox&);
  control::LineDecision decide(const height_map_t& map, line_plan_t& plan);
  control::LineDecision decide_by_pictures(line_plan_t& plan, Outbox&);
  control::LineMeasurement unread(std::int32_t layer, std::int32_t attempt) const;
  void tell_lines(const control::LineMeasurement&, line_plan_t& plan) const;
  void look_at(const camera_frame_t&, Outbox&);
  vision::LinePictureReading look_along(const LineStation&, const vision::Frame&) const;
  struct EndLook {
    HeightMap before, ink;  ///< around it, by the pictures of the layer before and of this one
    double level_mm = std::numeric_limits<double>::quiet_NaN();  ///< of the first layer's line; NaN: not seen
    bool goes_on = false;                                        ///< there is a line behind it
  };
  HeightMap ink_around(const Point2&, const vision::Frame&) const;
  vision::LineWindow end_window(const HeightMap& ink) const;
  void look_at_end(std::size_t end, const vision::Frame&);
  /// Error of an end of the ink that the layer added [mm]; NaN where the pictures do not tell.
  double end_error_mm(std::size_t end, std::int32_t layer) const;
  /// Empty where none goes on that has not been told.
  std::string new_end_that_goes_on(std::int32_t layer);
  /// Empty where the lines have grown, where nothing was to be printed, and where the pictures do not tell.
  std::string missing_growth(std::int32_t layer, const control::GrowthShare&, Outbox&);
  std::vector<control::SeenLine> seen_lines() const;
  /// That the next layer shall add, by station.
  std::vector<double> planned_sections(const control::LineDecision&) const;
  void add_looks(line_plan_t& plan, std::vector<LineReading>& total) const;
  void hold_height(control::LineMeasurement& measured) const;
  double squared_width(const control::LineMeasurement& measured, const line_plan_t& plan) const;

  Changes changes_;
  bool has_profiler_;
  control::LineController controller_;
  GridSpec grid_;
  double width_mm_;
  std::vector<LineReading> nominal_;  ///< of the target as the profiler sees it, by station
  HeightMap bare_;                    ///< of layer 0
  HeightMap before_, newest_;         ///< of the layer before, and of this one
  std::int32_t newest_layer_ = 0;
  std::int64_t paths_ = 0;
  std::vector<vision::Frame> bare_pictures_;
  vision::Frame flat_;
  std::int32_t looked_layer_ = 0;
  std::vector<vision::LinePictureReading> looks_;  ///< of that layer, by station; not seen where none came
  std::vector<LineReading> seen_before_, seen_;    ///< sections that the widths of the two layers stand for
  std::vector<EndLook> end_looks_;                 ///< the same by end
  std::vector<bool> told_;                         ///< ends that go on, as a stop said
  std::vector<std::vector<double>> planned_;       ///< sections by layer and station
  control::LineGrowth growth_;
  std::int32_t cut_layer_ = 0;   ///< the last one whose way was not wholly followed
  bool doubt_told_ = false;      ///< that pictures do not tell the growth
  std::int32_t told_layer_ = 0;  ///< that the last stop by pictures followed
};

}  // namespace firn
