// LineLoop sequences the commands of a print of lines: HEIGHT_MAP, LINE_PLAN, ANSWER_*, STATE_*, ENABLE,
// SAFE_STOP -> STAGE_COMMAND, PROFILER_COMMAND, PATH_REPORT, LAYER_METRICS, RUN_END.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/grid/grid.h"
#include "firn/height_map_t.hpp"
#include "firn/line_plan_t.hpp"
#include "procs/scheduler/scan_commands.h"
#include "procs/scheduler/scheduler.h"

namespace firn {

/// Coordinates one print of lines: scan, ask for a way, follow it with the shutter, scan again. A way that
/// was begun is never followed again: the next map says what lies there.
class LineLoop final : public Scheduler {
 public:
  LineLoop(const Experiment& experiment, HeightMap target, Mask mask);

  using Scheduler::on;
  void on(const height_map_t&, Time now, Outbox&);
  void on(const line_plan_t&, Time now, Outbox&);

 private:
  void proceed(Phase next, Time now, Outbox&) override;
  void answered(const answer_t&, Time now, Outbox&) override;
  void after_resume(Time now, Outbox&) override;
  void operator_accepted(Time now, Outbox&) override;
  std::int64_t act_size() const override { return way_.switches; }
  void scan_again(Time now, Outbox&) override;
  int command_layer() const override { return phase_ == Phase::kRunPath ? layers_done_ + 1 : layers_done_; }
  std::string awaited() const override;
  std::string doubt() const override;

  void act_on_map(Time now, Outbox&);
  void act_on_plan(Time now, Outbox&);
  /// Too little of the grid measured (I13). Returns false for a map to act on.
  bool rejected(const height_map_t&, Time now, Outbox&);
  /// A layer that is far thinner or thicker than planned: the shutter is stuck, or the nozzle is clogged
  /// (I12).
  bool stopped_by_rise(const line_plan_t&, Time now, Outbox&);
  /// Ink that the last layer left away from the lines, as far as it stands out of the noise [mm^3].
  double ink_beside_mm3() const;
  bool waits_for_operator() const;
  void settle(Outbox&);
  void publish_metrics(const height_map_t&, Outbox&);
  Swath swath() const { return {scan_id_, scan_attempt_, swath_, swaths_mm_.size(), swaths_mm_[swath_]}; }
  void send_scan(Time now, Outbox&);
  void send_profiler(ProfilerVerb verb, Time now, Outbox&);
  void send_way(Time now, Outbox&);

  HeightMap target_;
  Mask mask_;
  Mask beside_;                      ///< away from all lines
  HeightMap newest_, before_;        ///< the last map, and that of the layer before
  double noise_mm_ = 0.0;            ///< of a cell of it
  std::optional<height_map_t> map_;  ///< arrived, not acted on yet
  std::optional<line_plan_t> plan_;
  line_plan_t way_ = line_plan_t{};  ///< the one that is followed, or was last
  bool way_done_ = false;            ///< wholly
  bool in_doubt_ = false;
  std::int64_t way_began_us_ = 0;
  std::vector<double> swaths_mm_;
  std::size_t swath_ = 0;
  int scan_attempt_ = 0;
  std::int64_t scan_id_ = 0, map_id_ = 0, switches_total_ = 0;
  std::int32_t rows_lost_ = 0;
};

}  // namespace firn
