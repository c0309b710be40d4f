// DropletLoop sequences the commands of a print of droplets: HEIGHT_MAP, LAYER_PLAN, ANSWER_*, STATE_*,
// ENABLE, SAFE_STOP -> STAGE_COMMAND, JET_COMMAND, JET_B_COMMAND, PROFILER_COMMAND, LAMP_COMMAND,
// DEPOSITION_REPORT, LAYER_METRICS, RUN_END.
#pragma once

#include <optional>
#include <string>

#include "core/grid/grid.h"
#include "firn/height_map_t.hpp"
#include "firn/layer_metrics_t.hpp"
#include "procs/scheduler/layer_job.h"
#include "procs/scheduler/scheduler.h"

namespace firn {

/// Coordinates one print of droplets: scan, ask for a plan, then for each pass arm the jet of its ink, run
/// the stage, disarm and count, report, cure; then scan again. The passes of a layer and which of them share
/// a cure: pass_list.h. A jet is armed only when the pass before has disarmed its own, so that two jets never
/// are.
class DropletLoop final : public Scheduler {
 public:
  DropletLoop(const Experiment& experiment, HeightMap target, Mask mask);

  using Scheduler::on;
  void on(const height_map_t&, Time now, Outbox&);
  void on(const layer_plan_t&, Time now, Outbox&);

 private:
  void proceed(Phase next, Time now, Outbox&) override;
  void answered(const answer_t&, Time now, Outbox&) override;
  void answered_late(const answer_t&) override;
  void after_resume(Time now, Outbox&) override;
  void operator_accepted(Time now, Outbox&) override;
  std::int64_t act_size() const override { return job_.remaining(); }
  int command_layer() const override { return job_.finished() ? layers_done_ : job_.layer(); }
  bool only_counts() const override { return phase_ == Phase::kDisarmJet; }
  std::string awaited() const override;
  std::string doubt() const override;

  void act_on_map(Time now, Outbox&);
  void act_on_plan(Time now, Outbox&);
  bool stopped_by_rise(const height_map_t&, Time now, Outbox&);
  void settle_pass(const answer_t& jet, Outbox&);
  void publish_metrics(const height_map_t&, Outbox&);
  bool waits_for_operator() const;  ///< the open loop has droplets in doubt that nobody has accepted
  void send_pass(Time now, Outbox&);
  void send_park(Time now, Outbox&);
  void send_scan(Time now, Outbox&);
  void send_jet(JetVerb verb, Time now, Outbox&);
  void send_profiler(ProfilerVerb verb, Time now, Outbox&);
  void send_exposure(Time now, Outbox&);

  bool two_jets_;
  HeightMap target_;
  Mask mask_;
  std::optional<height_map_t> map_;  ///< arrived, not acted on yet
  std::optional<layer_plan_t> plan_;

  LayerJob job_;
  HeightMap below_;  ///< the last accepted map; without cells after a stop that asked for a look at the part
  int below_layer_ = 0;
  int scan_attempt_ = 0;
  std::int64_t scan_id_ = 0;
  std::int64_t map_id_ = 0;
  std::int64_t drops_total_ = 0;
  double objective_mm_ = 0.0;
  std::int64_t iterations_ = 0;
};

}  // namespace firn
