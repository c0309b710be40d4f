// LineController plans each layer of a job of lines: surface-mapping feedback [Barnett 2012, 5.1] in one
// dimension, along the way, acts on the speed; the shutter's delays follow from where lines begin and end.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "core/control/lines/focus_control.h"
#include "core/control/lines/line_options.h"
#include "core/control/options.h"
#include "core/grid/decision.h"
#include "core/path/line_stations.h"

namespace firn::control {

struct LineSetup {
  PrintJob job;
  motion::AerosolMachine machine;  ///< its shutter_delay_s is the first guess of both delays
  LineOptions options;
  SmfGains gains;
  double output_limit = 0.5;
  bool feedback = true;  ///< false: every layer as nominal
};

/// The lines as measured after `layer` layers.
struct LineMeasurement {
  std::int32_t layer = 0;
  std::int32_t attempt = 0;
  /// By station, in the order of line_stations(); area_mm2 NaN where not read.
  std::vector<LineReading> total;                   ///< all layers
  std::vector<LineReading> last;                    ///< the last layer alone
  double start_error_mm = 0.0, end_error_mm = 0.0;  ///< means over the free ends of the last layer, NaN: none
  /// All layers together: mean over the stations of (width / nominal width)^2; NaN: not known.
  double squared_width = std::numeric_limits<double>::quiet_NaN();
};

/// A way in knots, the acceleration constant between them, and the shutter's switches by the way travelled.
struct LineWay {
  std::vector<double> t_s, x_mm, y_mm, vx_mm_s, vy_mm_s;
  std::vector<double> switch_mm;
};

struct LineDecision {
  PlanDecision kind = PlanDecision::kPrint;
  std::string reason;
  LineWay way;
  std::vector<double> speed_mm_s;  ///< by station
  double duration_s = 0.0, open_s = 0.0, printed_mm = 0.0;
  double open_delay_s = 0.0, close_delay_s = 0.0;
  double flow_share = 1.0;    ///< mean expected in the planned layer
  double sheath_share = 1.0;  ///< of the nominal sheath gas, in the planned layer
};

/// e = (k A - area) / A by station, in layers of the nominal cross-section A = flow solids / speed; the next
/// layer shall have A (1 + U), U = Kp e + Ki* sum e + Kd* (e - e before) within +-output_limit (5.1), (5.2).
/// The speed is flow share x flow x solids / (A (1 + U)) within the range. The share of the nominal flow is
/// what the last layer's section says at the station's speed, and, fed forward, goes on as it changed from
/// layer to layer.
class LineController {
 public:
  /// @throws std::invalid_argument: an option outside its range; a job that the machine cannot print, with
  /// segment and reason
  explicit LineController(LineSetup setup);

  LineDecision decide(const LineMeasurement& measurement);
  const std::vector<LineStation>& stations() const { return stations_; }
  const std::vector<LineEnd>& ends() const { return ends_; }
  /// A by station [mm^2].
  double nominal_area_mm2(std::size_t station) const;
  void use_options(const LineOptions& options, const SmfGains& gains);

 private:
  void learn(const LineMeasurement& m);
  void learn_flow(const LineMeasurement& m);
  double foreseen_share(std::size_t station) const;
  motion::AerosolPlan plan(const std::vector<double>& speed_mm_s) const;

  LineSetup setup_;
  FocusControl focus_;
  std::vector<LineStation> stations_;
  std::vector<LineEnd> ends_;
  /// State after a layer; a second measurement of it starts from the state before.
  struct Memory {
    std::int32_t layer = 0;
    std::vector<double> sum, error;
    std::vector<double> share, share_before;  ///< of the flow, by station; empty: no layer yet
    double open_delay_s = 0.0, close_delay_s = 0.0;
    int open_seen = 0, close_seen = 0;
  };
  Memory before_, now_;
  std::vector<double> printed_speed_;   ///< of the layer that is measured next
  std::vector<double> measured_speed_;  ///< of the layer that was measured
};

/// Knots of a plan and the ways at which the shutter must be switched so that it is open over the plan's
/// spans.
LineWay way_of(const motion::AerosolPlan& plan, double open_delay_s, double close_delay_s);

}  // namespace firn::control
