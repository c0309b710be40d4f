// scheduler: HEIGHT_MAP, LAYER_PLAN, MATERIAL_MAP, ANSWER_*, STATE_*, ENABLE, SAFE_STOP -> STAGE_COMMAND, JET_COMMAND,
// JET_B_COMMAND, PROFILER_COMMAND, LAMP_COMMAND, DEPOSITION_REPORT, PASS_DETAIL, LAYER_METRICS, RUN_END.
#pragma once

#include <optional>
#include <string>

#include "config/experiment.h"
#include "core/grid/grid.h"
#include "firn/answer_t.hpp"
#include "firn/device_state_t.hpp"
#include "firn/enable_t.hpp"
#include "firn/height_map_t.hpp"
#include "firn/layer_metrics_t.hpp"
#include "firn/material_map_t.hpp"
#include "firn/operator_command_t.hpp"
#include "firn/safe_stop_t.hpp"
#include "lcmtypes/outcome.h"
#include "procs/scheduler/layer_job.h"
#include "runtime/node.h"

namespace firn {

/// Coordinates one print: scan, ask for a plan, then for each pass arm the jet of its ink, run the stage, disarm and
/// count, report, cure; then scan again. The passes of a layer and which of them share a cure: pass_list.h. At most one
/// command is outstanding, so after a crash at most one act is in doubt; a jet is armed only when the pass before has
/// disarmed its own, so that two jets never are.
class Scheduler : public Node {
 public:
  Scheduler(const Experiment& experiment, HeightMap target, Mask mask);

  void start(const Start&, Time now, Outbox&) override;
  void wake(TimerId, Time now, Outbox&) override;
  void on(const enable_t&, Time now, Outbox&);
  void on(const safe_stop_t&, Time now, Outbox&);
  void on(const device_state_t&, Time now, Outbox&);
  void on(const answer_t&, Time now, Outbox&);
  void on(const height_map_t&, Time now, Outbox&);
  void on(const layer_plan_t&, Time now, Outbox&);
  void on(const material_map_t&, Time now, Outbox&);
  void on(const operator_command_t&, Time now, Outbox&);

 private:
  /// What the print is doing; each is left by exactly one kind of message.
  enum class Phase {
    kGetReady,      // all drivers SAFE and the lease granted
    kHoming,
    kArmProfiler, kScan, kEndScan, kAwaitMap, kAwaitPlan,
    kArmJet, kPass, kDisarmJet, kPark, kCure,
    kStopped, kOver,
  };
  struct Pending {
    std::int64_t command_id = 0;
    NodeId driver{};
  };

  void proceed(Phase next, Time now, Outbox&);  ///< enters a phase: sends its command, arms its deadline
  void answered(const answer_t&, Time now, Outbox&);
  void act_on_map(Time now, Outbox&);
  void act_on_plan(Time now, Outbox&);
  void settle_pass(std::int64_t jet_counted, Outbox&);
  void after_resume(Time now, Outbox&);         ///< picks up the phase that the crash interrupted
  void try_ready(Time now, Outbox&);
  void finish_run(RunOutcome outcome, int status, const std::string& reason, Outbox&);
  void send_fault(Severity severity, int code, const std::string& text, Outbox&);
  void fail(int code, const std::string& text, Time now, Outbox&);  ///< FAULT that stops the print
  void publish_metrics(const height_map_t&, Outbox&);
  void count_phase_time(Time now);
  std::string overdue() const;                  ///< who is late, for the fault's text
  bool materials_known() const;                 ///< with two inks: of the map that is to be answered
  bool waits_for_operator() const;              ///< the open loop has droplets in doubt that nobody has accepted
  /// Fills in id, epoch and layer, and arms the deadline: allowed_s of node time, longer where wall time matters.
  template <class Command>
  void stamp(Command& command, NodeId driver, double allowed_s, Time now, Outbox&);
  void send_pass(Time now, Outbox&);
  void send_park(Time now, Outbox&);
  void send_scan(Time now, Outbox&);
  void send_jet(JetVerb verb, Time now, Outbox&);
  void send_profiler(ProfilerVerb verb, Time now, Outbox&);
  void send_exposure(Time now, Outbox&);

  Experiment experiment_;
  bool two_jets_;
  int all_drivers_ = 0;                  ///< bit per NodeId that takes part
  HeightMap target_;
  Mask mask_;

  std::int32_t incarnation_ = 0;
  int refused_ = 0;                      ///< times in a row that the command of this phase was refused
  Phase phase_ = Phase::kGetReady;
  Phase interrupted_ = Phase::kHoming;   ///< where to go on when ready
  std::optional<Pending> pending_;
  std::optional<answer_t> pass_answer_;  ///< what the stage said of the pass, until the jet is disarmed
  std::optional<height_map_t> map_;      ///< arrived, not acted on yet
  std::optional<layer_plan_t> plan_;
  std::optional<material_map_t> materials_;
  std::int64_t last_command_id_ = 0;
  std::int64_t epoch_ = 0;
  bool enabled_ = false;
  int safe_drivers_ = 0;                 ///< bit per NodeId
  bool doubt_accepted_ = false;

  LayerJob job_;
  int layers_done_ = 0;
  int scan_attempt_ = 0;
  std::int64_t scan_id_ = 0;
  std::int64_t map_id_ = 0;
  std::int64_t drops_total_ = 0;
  double objective_mm_ = 0.0;
  std::int64_t iterations_ = 0;

  Time phase_since_;
  double deposit_s_ = 0, cure_s_ = 0, scan_s_ = 0, decide_s_ = 0;
};

std::unique_ptr<Node> make_scheduler(const std::string& config_toml, const Blobs& blobs);

}  // namespace firn
