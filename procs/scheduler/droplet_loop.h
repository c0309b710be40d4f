// DropletLoop sequences the commands of a print of droplets: HEIGHT_MAP, LAYER_PLAN, DROPLET_SWEEP, ANSWER_*,
// STATE_*, ENABLE, SAFE_STOP -> STAGE_COMMAND, JET_COMMAND, JET_B_COMMAND, PROFILER_COMMAND, LAMP_COMMAND,
// CAMERA_COMMAND, DEPOSITION_REPORT, LAYER_METRICS, RUN_END.
#pragma once

#include <optional>
#include <string>

#include "core/grid/grid.h"
#include "core/grid/offsets.h"
#include "firn/droplet_sweep_t.hpp"
#include "procs/scheduler/layer_job.h"
#include "procs/scheduler/rise_check.h"
#include "procs/scheduler/scan_loop.h"

namespace firn {

/// Coordinates one print of droplets: scan, ask for a plan, then for each pass arm the jet of its ink, run
/// the stage, disarm and count, report, cure; then scan again. The passes of a layer and which of them share
/// a cure: pass_list.h. A jet is armed only when the pass before has disarmed its own, so that two jets never
/// are. With a camera, the jet is watched before layer 1 and every watch.every_layers: a strobe sweep beside
/// the part, judged by jet_check.h; a jet outside its band is purged once.
class DropletLoop final : public ScanLoop {
 public:
  DropletLoop(const Experiment& experiment, HeightMap target, Mask mask);

  using ScanLoop::on;
  void on(const layer_plan_t&, Time now, Outbox&);
  void on(const droplet_sweep_t&, Time now, Outbox&);
  void wake(TimerId, Time now, Outbox&) override;

 private:
  void proceed(Phase next, Time now, Outbox&) override;
  void answered(const answer_t&, Time now, Outbox&) override;
  void answered_late(const answer_t&) override;
  void after_resume(Time now, Outbox&) override;
  std::int64_t act_size() const override { return job_.remaining(); }
  int command_layer() const override { return job_.finished() ? layers_done_ : job_.layer(); }
  bool only_counts() const override { return phase_ == Phase::kDisarmJet; }
  std::string awaited() const override;
  std::string doubt() const override;

  std::string place() const;  ///< "before layer 7, pass 2", "before the scan of layer 7"
  void act_on_map(Time now, Outbox&) override;
  /// Measures again a layer whose map lacks too much, slower if rows were lost; after the last attempt the
  /// print stops, or goes on without the lost rows. Returns false for a map to act on.
  bool rejected(const height_map_t&, Time now, Outbox&);
  void act_on_plan(Time now, Outbox&) override;
  /// The bare table and the first layer's place, against the calibrated uncertainty: a warning and another
  /// scan, then a stop. Returns false for a map to act on.
  HeightMap on_part(HeightMap height) const;  ///< NaN beside the part
  bool doubted(const height_map_t&, Time now, Outbox&);
  bool stopped_by_rise(const height_map_t&, Time now, Outbox&);
  /// Interlock 6: a map that reaches into the nozzle's clearance is measured again, then stops the print.
  /// Returns false for a map to act on.
  bool stopped_by_height(const height_map_t&, Time now, Outbox&);
  void settle_pass(const answer_t& jet, Outbox&);
  void publish_metrics(const height_map_t&, Time now, Outbox&);
  bool waits_for_operator() const override;
  void forget_plan() override { plan_.reset(); }
  void send_pass(Time now, Outbox&);
  double scan_speed_mm_s() const override {
    return experiment().process.scan_speed_mm_s / double(1 << slower_);
  }
  void send_jet(JetVerb verb, Time now, Outbox&);
  void send_exposure(Time now, Outbox&);
  // The watch of the jet: watch_jet.cpp
  bool watch_due() const;
  bool volume_first() const;
  bool enter_watch(Phase, Time now, Outbox&);  ///< false: no phase of it
  bool watch_answered(Time now, Outbox&);      ///< the same
  void act_on_sweep(Time now, Outbox&);
  void send_jetting(JetVerb verb, Time now, Outbox&);
  void send_pictures(Time now, Outbox&);

  bool two_jets_;
  OffsetTable places_;
  Mask inside_, rim_;  ///< of the mask: RMS is reported apart
  std::optional<layer_plan_t> plan_;

  LayerJob job_;
  HeightMap below_;  ///< the last accepted map; without cells after a stop that asked for a look at the part
  int below_layer_ = 0;
  double below_std_mm_ = 0.0;  ///< noise of its cells
  RiseCheck rise_;
  HeightMap bare_;  ///< of layer 0, until the first layer's map is accepted
  int slower_ = 0;  ///< scans have this many times half the configured speed
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
