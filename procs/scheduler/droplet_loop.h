// DropletLoop sequences the commands of a print of droplets: HEIGHT_MAP, LAYER_PLAN, DROPLET_SWEEP, ANSWER_*,
// STATE_*, ENABLE, SAFE_STOP -> STAGE_COMMAND, JET_COMMAND, JET_B_COMMAND, PROFILER_COMMAND, LAMP_COMMAND,
// CAMERA_COMMAND, DEPOSITION_REPORT, LAYER_METRICS, RUN_END.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/grid/grid.h"
#include "firn/droplet_sweep_t.hpp"
#include "firn/height_map_t.hpp"
#include "firn/layer_metrics_t.hpp"
#include "procs/scheduler/layer_job.h"
#include "procs/scheduler/scan_commands.h"
#include "procs/scheduler/scheduler.h"

namespace firn {

/// Coordinates one print of droplets: scan, ask for a plan, then for each pass arm the jet of its ink, run
/// the stage, disarm and count, report, cure; then scan again. The passes of a layer and which of them share
/// a cure: pass_list.h. A jet is armed only when the pass before has disarmed its own, so that two jets never
/// are. With a camera, the jet is watched before layer 1 and every watch.every_layers: a strobe sweep beside
/// the part, judged by jet_check.h; a jet outside its band is purged once.
class DropletLoop final : public Scheduler {
 public:
  DropletLoop(const Experiment& experiment, HeightMap target, Mask mask);

  using Scheduler::on;
  void on(const height_map_t&, Time now, Outbox&);
  void on(const layer_plan_t&, Time now, Outbox&);
  void on(const droplet_sweep_t&, Time now, Outbox&);
  void wake(TimerId, Time now, Outbox&) override;

 private:
  void proceed(Phase next, Time now, Outbox&) override;
  void answered(const answer_t&, Time now, Outbox&) override;
  void answered_late(const answer_t&) override;
  void after_resume(Time now, Outbox&) override;
  void operator_accepted(Time now, Outbox&) override;
  std::int64_t act_size() const override { return job_.remaining(); }
  void scan_again(Time now, Outbox&) override;
  int command_layer() const override { return job_.finished() ? layers_done_ : job_.layer(); }
  bool only_counts() const override { return phase_ == Phase::kDisarmJet; }
  std::string awaited() const override;
  std::string doubt() const override;

  std::string place() const;  ///< "before layer 7, pass 2", "before the scan of layer 7"
  void act_on_map(Time now, Outbox&);
  /// Measures again a layer whose map lacks too much, slower if rows were lost; after the last attempt the
  /// print stops, or goes on without the lost rows. Returns false for a map to act on.
  bool rejected(const height_map_t&, Time now, Outbox&);
  void act_on_plan(Time now, Outbox&);
  /// The bare table and the first layer's place, against the calibrated uncertainty: a warning and another
  /// scan, then a stop. Returns false for a map to act on.
  bool doubted(const height_map_t&, Time now, Outbox&);
  bool stopped_by_rise(const height_map_t&, Time now, Outbox&);
  /// Interlock 6: a map that reaches into the nozzle's clearance is measured again, then stops the print.
  /// Returns false for a map to act on.
  bool stopped_by_height(const height_map_t&, Time now, Outbox&);
  void settle_pass(const answer_t& jet, Outbox&);
  void publish_metrics(const height_map_t&, Outbox&);
  bool waits_for_operator() const;  ///< the open loop has droplets in doubt that nobody has accepted
  void send_pass(Time now, Outbox&);
  void send_park(Time now, Outbox&);
  Swath swath() const { return {scan_id_, scan_attempt_, swath_, swaths_mm_.size(), swaths_mm_[swath_]}; }
  void send_scan(Time now, Outbox&);
  double scan_speed_mm_s() const { return experiment().process.scan_speed_mm_s / double(1 << slower_); }
  void send_jet(JetVerb verb, Time now, Outbox&);
  void send_profiler(ProfilerVerb verb, Time now, Outbox&);
  void send_exposure(Time now, Outbox&);
  // watch_jet.cpp
  bool watch_due() const;
  bool enter_watch(Phase, Time now, Outbox&);  ///< false: no phase of it
  bool watch_answered(Time now, Outbox&);      ///< the same
  void act_on_sweep(Time now, Outbox&);
  void send_to_camera(Time now, Outbox&);
  void send_jetting(JetVerb verb, Time now, Outbox&);
  void send_pictures(Time now, Outbox&);

  bool two_jets_;
  HeightMap target_;
  Mask mask_;
  Mask inside_, rim_;                ///< of the mask: RMS is reported apart
  std::optional<height_map_t> map_;  ///< arrived, not acted on yet
  std::optional<layer_plan_t> plan_;

  LayerJob job_;
  HeightMap below_;  ///< the last accepted map; without cells after a stop that asked for a look at the part
  int below_layer_ = 0;
  HeightMap bare_;                 ///< of layer 0, until the first layer's map is accepted
  std::vector<double> swaths_mm_;  ///< shifts of the stage; one of 0 where the profiler's line is long enough
  std::size_t swath_ = 0;
  int scan_attempt_ = 0;
  std::int32_t rows_lost_ = 0;  ///< of the layer's scans so far
  int slower_ = 0;              ///< scans have this many times half the configured speed
  std::int64_t scan_id_ = 0;
  std::int64_t map_id_ = 0;
  std::int64_t drops_total_ = 0;
  double objective_mm_ = 0.0;
  std::int64_t iterations_ = 0;

  std::optional<droplet_sweep_t> sweep_;  ///< arrived, not acted on yet
  std::int64_t sweep_id_ = 0;
  int watched_layer_ = 0;  ///< before which the jet was last found good; 0 = never
  bool purged_ = false;    ///< since then
  double lead_mm_ = 0.0;
};

}  // namespace firn
