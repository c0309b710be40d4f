// LineLoop sequences the commands of a print of lines: HEIGHT_MAP, LINE_PLAN, FOLLOWED_PATH, TEMPERATURE,
// ANSWER_*, STATE_*, ENABLE, SAFE_STOP -> STAGE_COMMAND, PROFILER_COMMAND, GAS_COMMAND, HEATER_COMMAND,
// PATH_REPORT, LAYER_METRICS, RUN_END.
#pragma once

#include <optional>
#include <string>

#include "core/grid/grid.h"
#include "core/path/followed_path.h"
#include "core/path/line_stations.h"
#include "firn/followed_path_t.hpp"
#include "firn/line_plan_t.hpp"
#include "firn/temperature_t.hpp"
#include "procs/scheduler/scan_loop.h"

namespace firn {

/// Coordinates one print of lines: platen, gas, then scan, ask for a way, follow it with the shutter, scan
/// again. A way that was begun is never followed again: the next map says what lies there. A camera takes a
/// picture of each station before each scan. Without a profiler the pictures are the scan: also of each end,
/// and the way is the answer to the last of them.
class LineLoop final : public ScanLoop {
 public:
  LineLoop(const Experiment& experiment, HeightMap target, Mask mask, const PrintJob& job);

  using ScanLoop::on;
  void on(const line_plan_t&, Time now, Outbox&);
  void on(const temperature_t&, Time now, Outbox&);
  void on(const followed_path_t&, Time now, Outbox&);
  void wake(TimerId, Time now, Outbox&) override;

 private:
  void proceed(Phase next, Time now, Outbox&) override;
  void answered(const answer_t&, Time now, Outbox&) override;
  void after_resume(Time now, Outbox&) override;
  std::int64_t act_size() const override { return way_.switches; }
  int command_layer() const override { return phase_ == Phase::kRunPath ? layers_done_ + 1 : layers_done_; }
  std::string doubt() const override;
  std::string awaited() const override;

  // Platen and gas: line_supply.cpp
  bool has_gas() const;
  bool heats() const;
  static bool supplies(Phase);
  /// Enters one of the phases of platen and gas; false: another one.
  bool enter_supply(Phase, Time now, Outbox&);
  /// Goes on after the command of such a phase; false: another phase.
  bool supply_answered(Time now, Outbox&);
  void act_on_temperature(Time now, Outbox&);
  void send_platen(Time now, Outbox&);
  void send_gas(double atomizer_sccm, double sheath_sccm, Time now, Outbox&);
  void end_print(Outbox&);

  void supplied(Time now, Outbox&);  ///< goes on with the phase that waited for platen and gas
  void act_on_map(Time now, Outbox&) override;
  void act_on_plan(Time now, Outbox&) override;
  /// Too little of the grid measured (I13). Returns false for a map to act on.
  bool rejected(const height_map_t&, Time now, Outbox&);
  /// A layer that is far thinner or thicker than planned: the shutter is stuck, or the nozzle is clogged
  /// (I12).
  bool stopped_by_rise(const line_plan_t&, Time now, Outbox&);
  /// Ink that the last layer left away from the lines, as far as it stands out of the noise [mm^3].
  double ink_beside_mm3() const;
  bool waits_for_operator() const override;
  void forget_plan() override { plan_.reset(); }
  void settle(const PathErrors& errors, Outbox&);
  // The path that the stage followed.
  /// The stage has answered and its followed path is here, or none is recorded.
  void path_over(Time now, Outbox&);
  bool path_recorded() const;
  PathErrors errors_of_way() const;
  /// The followed path, or a place of the shutter, is too far from the planned one (I17); empty: it is not.
  Violation off_path(const PathErrors& errors) const;
  /// The same, as far as pictures say it: no line after a layer, or lines that do not end.
  bool stopped_by_pictures(const line_plan_t&, Time now, Outbox&);
  void publish_metrics(layer_metrics_t, Outbox&);
  void send_way(Time now, Outbox&);
  /// The camera has a picture of each station to take before the scan of this layer.
  bool look_due() const;
  void send_to_place(Time now, Outbox&);
  void send_picture(Time now, Outbox&);

  Mask beside_;                ///< away from all lines
  HeightMap newest_, before_;  ///< the last map, and that of the layer before
  double noise_mm_ = 0.0;      ///< of a cell of it
  std::optional<line_plan_t> plan_;
  line_plan_t way_ = line_plan_t{};          ///< the one that is followed, or was last
  std::optional<followed_path_t> followed_;  ///< of the last way
  std::vector<LineStation> stations_;
  bool way_done_ = false;  ///< wholly
  bool in_doubt_ = false;
  std::int64_t way_began_us_ = 0;
  std::int64_t switches_total_ = 0;

  Phase after_supply_ = Phase::kHoming;
  double sheath_share_ = 1.0;      ///< of gas.sheath_sccm, in the layer that is printed
  std::optional<Time> gas_since_;  ///< both flows were there; nothing: since no time of this incarnation
  std::optional<temperature_t> temperature_;
  bool has_profiler_;
  std::vector<Point2> places_;  ///< that the camera walks: stations, without a profiler ends too
  std::size_t look_ = 0;        ///< the next one
  int looked_layer_ = -1;       ///< all pictures of it are taken
};

}  // namespace firn
