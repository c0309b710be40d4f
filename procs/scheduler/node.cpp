#include "procs/scheduler/node.h"

#include <algorithm>
#include <cmath>

#include "core/grid/npy.h"
#include "firn/fault_t.hpp"
#include "firn/run_end_t.hpp"
#include "lcmtypes/convert.h"
#include "procs/scheduler/timers.h"

namespace firn {
namespace {

constexpr int bit(NodeId n) { return 1 << int(n); }
constexpr int kMostRefusals = 10;
constexpr double kAgainWall_s = 0.05;  // about one period of the lease

}  // namespace

Scheduler::Scheduler(const Experiment& experiment, HeightMap target, Mask mask)
    : experiment_(experiment), two_jets_(has_two_jets(experiment)), target_(std::move(target)), mask_(std::move(mask)) {
  for (const NodeInfo& n : nodes()) {
    if (!n.driver) continue;
    subscribe(channels::answer(n.id), this);
    subscribe(channels::device_state(n.id), this);
    if (takes_part(experiment_, n.name)) all_drivers_ |= bit(n.id);
  }
  subscribe(channels::kEnable, this);
  subscribe(channels::kSafeStop, this);
  subscribe(channels::kHeightMap, this);
  subscribe(channels::kLayerPlan, this);
  subscribe(channels::kMaterialMap, this);
  subscribe(channels::kOperatorCommand, this);
}

void Scheduler::start(const Start& start, Time now, Outbox& out) {
  if (phase_ == Phase::kOver) return;
  incarnation_ = start.incarnation;
  enabled_ = false;
  safe_drivers_ = 0;
  if (start.resumed() && phase_ != Phase::kGetReady && phase_ != Phase::kStopped) interrupted_ = phase_;
  phase_ = Phase::kGetReady;
  phase_since_ = now;
  // Instruments connect, identify and home in this time.
  out.wake_at(kDeadline, now.after_s(60.0 * experiment_.run.time_scale));
}

void Scheduler::on(const enable_t& m, Time now, Outbox& out) {
  epoch_ = std::max(epoch_, m.enable_epoch);
  enabled_ = m.enabled && m.enable_epoch == epoch_;
  try_ready(now, out);
}

void Scheduler::on(const device_state_t& m, Time now, Outbox& out) {
  const NodeInfo* node = find_node(m.node);
  if (!node || m.header.incarnation < incarnation_) return;  // of before the resume, delivered only now
  if (DeviceState(m.state) == DeviceState::kSafe)
    safe_drivers_ |= bit(node->id) & all_drivers_;
  else
    safe_drivers_ &= ~bit(node->id);
  try_ready(now, out);
}

void Scheduler::on(const safe_stop_t& m, Time, Outbox& out) {
  if (phase_ == Phase::kStopped || phase_ == Phase::kOver) return;
  epoch_ = std::max(epoch_, m.enable_epoch);
  if (phase_ != Phase::kGetReady) interrupted_ = phase_;
  phase_ = Phase::kStopped;
  enabled_ = false;
  finish_run(RunOutcome::kStoppedSafely, 3, m.cause, out);
}

void Scheduler::on(const operator_command_t& m, Time now, Outbox& out) {
  if (OperatorVerb(m.verb) != OperatorVerb::kAcceptDoubt) return;
  doubt_accepted_ = true;
  out.cancel(kOperator);
  if (phase_ == Phase::kAwaitPlan) act_on_plan(now, out);
}

void Scheduler::try_ready(Time now, Outbox& out) {
  if (phase_ != Phase::kGetReady || !enabled_ || safe_drivers_ != all_drivers_ || pending_) return;
  after_resume(now, out);
}

// The phase in which the crash came is entered again, except where that could fire a droplet twice.
void Scheduler::after_resume(Time now, Outbox& out) {
  switch (interrupted_) {
    case Phase::kArmProfiler:
    case Phase::kScan:
    case Phase::kEndScan:
      ++scan_attempt_;
      return proceed(Phase::kArmProfiler, now, out);
    case Phase::kPass:
      return proceed(Phase::kDisarmJet, now, out);  // with pass_answer_, whatever it says
    default:
      return proceed(interrupted_, now, out);
  }
}

void Scheduler::wake(TimerId timer, Time now, Outbox& out) {
  if (phase_ == Phase::kOver || phase_ == Phase::kStopped) return;
  if (timer == kAgain) return phase_ == Phase::kGetReady || pending_ ? void() : proceed(phase_, now, out);
  if (timer == kOperator) {
    return finish_run(RunOutcome::kWaitsForOperator, 3,
                      "droplets of layer " + std::to_string(job_.layer()) +
                          " are in doubt and the open loop cannot correct them: look at the part, then resume with --accept-doubt",
                      out);
  }
  if (phase_ == Phase::kGetReady && pending_ && safe_drivers_ == all_drivers_) {
    // The driver is back and says nothing of the command: of a pass, all is in doubt; anything else is begun again.
    if (interrupted_ == Phase::kPass) {
      answer_t doubt;
      doubt.outcome = std::int8_t(Outcome::kUnknown);
      doubt.counted = -1;
      doubt.unknown_from = 0;
      doubt.unknown_to = job_.remaining();
      pass_answer_ = doubt;
    }
    pending_.reset();
    out.wake_at(kDeadline, now.after_s(30.0 * experiment_.run.time_scale));
    return try_ready(now, out);
  }
  fail(5, overdue() + " within " + std::to_string(seconds_between(phase_since_, now)) + " s", now, out);
}

std::string Scheduler::overdue() const {
  if (phase_ == Phase::kGetReady) {
    std::string missing;
    for (const NodeInfo& n : nodes())
      if ((all_drivers_ & ~safe_drivers_) & bit(n.id)) missing += (missing.empty() ? "" : ", ") + std::string(n.name);
    return missing.empty() ? "safety has not granted the lease" : missing + " not SAFE";
  }
  if (pending_)
    return std::string(info(pending_->driver).name) + " has not answered command " + std::to_string(pending_->command_id);
  if (phase_ == Phase::kAwaitMap) return "no height map for scan " + std::to_string(scan_id_);
  return (plan_ ? "no materials" : "no plan") + (" for map " + std::to_string(map_id_));
}

void Scheduler::on(const answer_t& m, Time now, Outbox& out) {
  if (!pending_ || m.command_id != pending_->command_id) return;  // repeated, or of an older incarnation
  pending_.reset();
  out.cancel(kDeadline);
  if (phase_ != Phase::kGetReady && phase_ != Phase::kStopped) return answered(m, now, out);
  // Answer to the command that the crash or the stop interrupted: kept until the print goes on.
  if (interrupted_ == Phase::kPass) pass_answer_ = m;
  if (interrupted_ == Phase::kCure && Outcome(m.outcome) == Outcome::kDone) interrupted_ = Phase::kArmJet;
  if (phase_ == Phase::kGetReady) out.wake_at(kDeadline, now.after_s(60.0 * experiment_.run.time_scale));
  try_ready(now, out);
}

void Scheduler::answered(const answer_t& m, Time now, Outbox& out) {
  const Outcome outcome = Outcome(m.outcome);
  // Refused is not begun. The lease can reach the scheduler before it reaches the driver, so it is tried again.
  if (outcome == Outcome::kRefused && refused_ < kMostRefusals) {
    ++refused_;
    return out.wake_at(kAgain, now.after_s(kAgainWall_s * experiment_.run.time_scale));
  }
  refused_ = 0;
  if (phase_ == Phase::kPass) pass_answer_ = m;
  if (outcome != Outcome::kDone && outcome != Outcome::kReady) return fail(m.code, m.node + ": " + m.text, now, out);
  switch (phase_) {
    case Phase::kHoming: return proceed(Phase::kArmProfiler, now, out);
    case Phase::kArmProfiler: return proceed(Phase::kScan, now, out);
    case Phase::kScan: return proceed(Phase::kEndScan, now, out);
    case Phase::kEndScan: return proceed(Phase::kAwaitMap, now, out);
    case Phase::kArmJet: return proceed(Phase::kPass, now, out);
    case Phase::kPass: return proceed(Phase::kDisarmJet, now, out);
    case Phase::kDisarmJet:
      settle_pass(m.counted, out);
      return proceed(job_.cure_due() ? Phase::kPark : Phase::kArmJet, now, out);
    case Phase::kPark: return proceed(Phase::kCure, now, out);
    case Phase::kCure: return proceed(Phase::kArmJet, now, out);  // which scans when no pass is left
    default: return;
  }
}

void Scheduler::settle_pass(std::int64_t jet_counted, Outbox& out) {
  if (!pass_answer_) return;
  if (job_.detailed()) out.send(channels::kPassDetail, job_.detail());
  const deposition_report_t report = job_.settle(*pass_answer_, jet_counted);
  pass_answer_.reset();
  drops_total_ += report.unknown_from;
  if (job_.in_doubt()) doubt_accepted_ = false;
  out.send(channels::kDepositionReport, report);
}

// A map can overtake the profiler's last answer, or arrive while the lab gets ready again: it is kept until its turn.
void Scheduler::on(const height_map_t& m, Time now, Outbox& out) {
  if (m.layer != layers_done_ || m.attempt != scan_attempt_ || m.map_id == map_id_) return;
  map_ = m;
  if (phase_ == Phase::kAwaitMap) act_on_map(now, out);
}

void Scheduler::act_on_map(Time now, Outbox& out) {
  if (!map_) return;
  const height_map_t m = std::move(*map_);
  map_.reset();
  out.cancel(kDeadline);
  if (from_message(m.grid) != experiment_.grid) return fail(0, "HEIGHT_MAP: grid is not the experiment's", now, out);
  const double needed = experiment_.process.min_measured_fraction;
  if (m.measured_fraction < needed) {
    const std::string what = "height map of layer " + std::to_string(m.layer) + " measures " +
                             std::to_string(m.measured_fraction) + " of the grid; " + std::to_string(needed) + " is needed";
    if (scan_attempt_ >= experiment_.process.max_rescans) return fail(13, what, now, out);
    send_fault(Severity::kWarning, 13, what + "; measuring again", out);
    ++scan_attempt_;
    return proceed(Phase::kArmProfiler, now, out);
  }
  map_id_ = m.map_id;
  count_phase_time(now);
  publish_metrics(m, out);
  deposit_s_ = cure_s_ = scan_s_ = decide_s_ = 0;
  proceed(Phase::kAwaitPlan, now, out);
}

// A plan too can arrive before the scheduler has acted on the map that it answers.
void Scheduler::on(const layer_plan_t& m, Time now, Outbox& out) {
  if (m.attempt != scan_attempt_ || m.layer != layers_done_ + 1) return;
  plan_ = m;
  if (phase_ == Phase::kAwaitPlan) act_on_plan(now, out);
}

void Scheduler::on(const material_map_t& m, Time now, Outbox& out) {
  if (!two_jets_ || m.attempt != scan_attempt_ || m.layer != layers_done_ + 1) return;
  materials_ = m;
  if (phase_ == Phase::kAwaitPlan) act_on_plan(now, out);
}

bool Scheduler::materials_known() const { return !two_jets_ || (materials_ && materials_->map_id == map_id_); }

void Scheduler::act_on_plan(Time now, Outbox& out) {
  if (!plan_ || plan_->map_id != map_id_ || waits_for_operator()) return;
  if (PlanDecision(plan_->decision) == PlanDecision::kPrint && !materials_known()) return;
  const layer_plan_t m = *plan_;
  out.cancel(kDeadline);
  if (PlanDecision(m.decision) == PlanDecision::kEnd) return finish_run(RunOutcome::kFinished, 0, m.reason, out);
  if (PlanDecision(m.decision) == PlanDecision::kStop) return finish_run(RunOutcome::kWaitsForOperator, 3, m.reason, out);
  if (from_message(m.grid) != experiment_.grid) return fail(0, "LAYER_PLAN: grid is not the experiment's", now, out);
  if (m.layer > experiment_.control.max_layers)
    return finish_run(RunOutcome::kWaitsForOperator, 3,
                      "control.max_layers = " + std::to_string(experiment_.control.max_layers) + " is reached", out);
  plan_.reset();
  objective_mm_ = m.objective_mm;
  iterations_ = m.iterations;
  try {
    job_ = LayerJob(m, two_jets_ ? materials_of(*materials_) : MaterialMap{}, experiment_.process.sub_patterns);
  } catch (const std::invalid_argument& problem) {
    return fail(0, std::string("LAYER_PLAN: ") + problem.what(), now, out);
  }
  materials_.reset();
  proceed(Phase::kArmJet, now, out);
}

bool Scheduler::waits_for_operator() const {
  return job_.in_doubt() && experiment_.control.scheme == "open_loop" && !doubt_accepted_;
}

void Scheduler::send_fault(Severity severity, int code, const std::string& text, Outbox& out) {
  fault_t f;
  f.severity = std::int8_t(severity);
  f.code = code;
  f.node = "scheduler";
  f.text = text;
  out.send(channels::fault(NodeId::kScheduler), f);
}

void Scheduler::fail(int code, const std::string& text, Time now, Outbox& out) {
  send_fault(Severity::kStop, code, text, out);
  count_phase_time(now);
  if (phase_ != Phase::kGetReady) interrupted_ = phase_;
  phase_ = Phase::kStopped;
  finish_run(RunOutcome::kStoppedSafely, 3, text, out);
}

void Scheduler::finish_run(RunOutcome outcome, int status, const std::string& reason, Outbox& out) {
  run_end_t end;
  end.outcome = std::int8_t(outcome);
  end.layers = layers_done_;
  end.reason = reason;
  out.cancel(kDeadline);
  out.cancel(kOperator);
  if (outcome == RunOutcome::kFinished) phase_ = Phase::kOver;
  if (outcome == RunOutcome::kWaitsForOperator) {
    interrupted_ = phase_;
    phase_ = Phase::kStopped;
  }
  out.send(channels::kRunEnd, end);
  out.finish(status, reason);
}

std::unique_ptr<Node> make_scheduler(const std::string& config_toml, const Blobs& blobs) {
  const Experiment e = parse_experiment(config_toml, "experiment.toml");
  return std::make_unique<Scheduler>(e, height_map_from_npy(blob(blobs, "target").bytes, e.grid, "target"),
                                     mask_from_npy(blob(blobs, "mask").bytes, e.grid, "mask"));
}

}  // namespace firn
