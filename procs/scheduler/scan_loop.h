// ScanLoop holds what the loops of labs with a profiler over a stage have in common: homing, the scan in
// swaths, the wait for its map and for the plan, and the layer's metrics.
#pragma once

#include <optional>
#include <vector>

#include "core/grid/grid.h"
#include "firn/height_map_t.hpp"
#include "firn/layer_metrics_t.hpp"
#include "procs/scheduler/scan_commands.h"
#include "procs/scheduler/scheduler.h"

namespace firn {

class ScanLoop : public Scheduler {
 public:
  using Scheduler::on;
  void on(const height_map_t&, Time now, Outbox&);

 protected:
  ScanLoop(const Experiment& experiment, Phase act, HeightMap target, Mask mask);

  virtual void act_on_map(Time now, Outbox&) = 0;
  virtual void act_on_plan(Time now, Outbox&) = 0;
  virtual bool waits_for_operator() const = 0;  ///< an act in doubt that nobody has accepted
  virtual void forget_plan() = 0;
  virtual double scan_speed_mm_s() const { return experiment().process.scan_speed_mm_s; }

  /// Enters one of the phases from kHoming to kAwaitPlan; false: another one.
  bool enter_scan(Phase, Time now, Outbox&);
  /// Goes on after the command of such a phase; false: another phase.
  bool scan_answered(Time now, Outbox&);
  void scan_again(Time now, Outbox&) override;
  void operator_accepted(Time now, Outbox&) override;
  /// "no height map for scan 7" in kAwaitMap, else "no plan for map 7".
  std::string awaited() const override;

  /// Moves the stage to a place, the nozzle at its gap.
  void send_move(double x_mm, double y_mm, Time now, Outbox&);

  /// Errors, heights and times of a map that is acted on; afterwards the times count from zero.
  layer_metrics_t metrics_of(const height_map_t&, Time now);
  /// Their times alone.
  layer_metrics_t times_of_layer(Time now);
  const HeightMap& target() const { return target_; }

  Mask mask_;
  std::optional<height_map_t> map_;  ///< arrived, not acted on yet
  int scan_attempt_ = 0;
  std::int32_t rows_lost_ = 0;  ///< of the layer's scans so far
  std::int64_t scan_id_ = 0;
  std::int64_t map_id_ = 0;

 private:
  Swath swath() const { return {scan_id_, scan_attempt_, swath_, swaths_mm_.size(), swaths_mm_[swath_]}; }
  void send_home(Time now, Outbox&);
  void send_scan(Time now, Outbox&);
  void send_profiler(ProfilerVerb verb, Time now, Outbox&);

  HeightMap target_;
  std::vector<double> swaths_mm_;  ///< shifts of the stage; one of 0 where the profiler's line is long enough
  std::size_t swath_ = 0;
};

}  // namespace firn
