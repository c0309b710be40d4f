// Scheduler holds the part of the print loop common to all kinds of labs: start under the lease, one command
// at a time, late, refused and missing answers, faults, resume, the end of the run.
#pragma once

#include <optional>
#include <string>

#include "config/changes.h"
#include "config/experiment.h"
#include "core/grid/figure.h"
#include "firn/answer_t.hpp"
#include "firn/device_state_t.hpp"
#include "firn/enable_t.hpp"
#include "firn/enums.h"
#include "firn/operator_command_t.hpp"
#include "firn/safe_stop_t.hpp"
#include "procs/scheduler/timers.h"
#include "runtime/node.h"

namespace firn {

/// At most one command is outstanding, so after a crash at most one act is in doubt. A loop implements
/// proceed(), which sends the command of each phase, and answered(), which selects the next phase. The act is
/// the phase whose repetition could deposit twice.
class Scheduler : public Node {
 public:
  void start(const Start&, Time now, Outbox&) override;
  void wake(TimerId, Time now, Outbox&) override;
  void on(const enable_t&, Time now, Outbox&);
  void on(const safe_stop_t&, Time now, Outbox&);
  void on(const device_state_t&, Time now, Outbox&);
  void on(const answer_t&, Time now, Outbox&);
  void on(const operator_command_t&, Time now, Outbox&);

 protected:
  /// Phases of the print; exactly one kind of message ends each phase.
  enum class Phase {
    kGetReady,  // all drivers SAFE and the lease granted
    kHoming,
    kArmProfiler,
    kScan,
    kEndScan,
    kAwaitMap,
    kAwaitPlan,  // droplets
    kToCamera,
    kPurging,
    kEndPurge,
    kJetting,
    kPictures,
    kEndJetting,
    kAwaitSweep,
    kArmJet,
    kPass,
    kDisarmJet,
    kPark,
    kCure,
    kHeat,
    kWarmUp,
    kGas,
    kGasSettles,
    kGasOff,
    kAwaitPaths,
    kAwaitSurface,  // paths
    kLoadPath,
    kLoadPulses,
    kArmValve,
    kRunPath,
    kDisarmValve,
    kAwaitOperator,
    kRaise,
    kLoadScan,
    kArmLaser,
    kRunScan,
    kCollect,
    kStopped,
    kOver,
  };
  struct Pending {
    std::int64_t command_id = 0;
    NodeId driver{};
  };

  /// @param act the phase that deposits
  Scheduler(const Experiment& experiment, Phase act);

  virtual void proceed(Phase next, Time now,
                       Outbox&) = 0;  ///< enters a phase: sends its command, arms its deadline
  virtual void answered(const answer_t&, Time now, Outbox&) = 0;  ///< the command of the phase is done
  virtual void answered_late(const answer_t&) {
  }  ///< the same for the interrupted phase, before the print continues
  virtual bool only_counts() const {
    return false;
  }  ///< whatever its outcome, the answer to this phase is a count
  virtual void after_resume(Time now, Outbox&) = 0;  ///< picks up the phase that the crash interrupted
  virtual void operator_accepted(Time now, Outbox&) = 0;
  virtual std::int64_t act_size() const = 0;       ///< all in doubt if the driver has no record of the act
  virtual void scan_again(Time now, Outbox&) = 0;  ///< with a new number of the attempt
  virtual int command_layer() const = 0;
  virtual std::string awaited() const = 0;  ///< the overdue message in a phase without a command
  virtual std::string doubt() const = 0;    ///< the question to the operator

  void try_ready(Time now, Outbox&);
  /// Call on entering a phase where the lab can wait: no instrument armed, nothing wet. Returns true if the
  /// operator has paused the print; proceed(phase_) is called when the print goes on.
  bool holds(const std::string& place, Outbox&);
  /// Returns true if the operator wants no further layer; the print has ended then.
  bool ended_by_operator(Phase resume_at, Outbox&);
  void finish_run(RunOutcome outcome, int status, const std::string& reason, Outbox&);
  /// FAULT that stops the print.
  void fail(int code, const std::string& text, Time now, Outbox&, const Figure& figure = {});
  /// Interlock 15. Returns true if the map is in doubt: it is measured once more, then the print stops.
  /// @param attempt number of the map's measurement @param measure the phase that a resume continues with
  bool stopped_by_doubt(const Violation& doubt, int attempt, Phase measure, Time now, Outbox&);
  void count_phase_time(Time now);
  /// Fills in id, epoch and layer, and arms the deadline: allowed_s of node time, longer where wall time
  /// matters.
  template <class Command>
  void stamp(Command& command, NodeId driver, double allowed_s, Time now, Outbox& out) {
    command.command_id = ++last_command_id_;
    command.enable_epoch = epoch_;
    command.layer = command_layer();
    pending_ = Pending{command.command_id, driver};
    out.wake_at(kDeadline, now.after_s(2.0 * allowed_s + kSlackWall_s * experiment().run.time_scale));
  }

  // Deadline: twice the planned time, plus this much wall time for links and a loaded machine.
  static constexpr double kSlackWall_s = 20.0;

  const Experiment& experiment() const { return changes_.experiment(); }

  Phase act_;
  Phase phase_ = Phase::kGetReady;
  Phase interrupted_ = Phase::kHoming;  ///< the phase to continue with when ready
  std::optional<answer_t> act_answer_;  ///< the driver's answer to the act, until the act is settled
  bool doubt_accepted_ = false;
  int layers_done_ = 0;
  double deposit_s_ = 0, cure_s_ = 0, scan_s_ = 0, decide_s_ = 0;

 private:
  void take_answer(const answer_t&, Time now, Outbox&);
  void go_on(Time now, Outbox&);  ///< after a pause
  std::string overdue() const;    ///< names the late driver or message, for the fault's text

  Changes changes_;
  bool paused_ = false, holding_ = false;
  bool last_layer_ = false;  ///< the operator wants no further layer
  bool map_doubted_ = false;
  int all_drivers_ = 0;  ///< bit per NodeId that takes part
  std::int32_t incarnation_ = 0;
  int refused_ = 0;  ///< times in a row that the command of this phase was refused
  std::optional<Pending> pending_;
  std::int64_t last_command_id_ = 0;
  std::int64_t epoch_ = 0;
  bool enabled_ = false;
  int safe_drivers_ = 0;  ///< bit per NodeId
  Time phase_since_;
};

/// Returns the loop of the experiment's lab. @throws std::invalid_argument, ConfigError
std::unique_ptr<Node> make_scheduler(const std::string& config_toml, const Blobs& blobs);

}  // namespace firn
