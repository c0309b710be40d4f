#include "procs/scheduler/scheduler.h"

#include <algorithm>
#include <utility>

#include "firn/run_end_t.hpp"
#include "lcmtypes/convert.h"

namespace firn {
namespace {

constexpr int bit(NodeId n) { return 1 << int(n); }
constexpr int kMaxRefusals = 10;
constexpr double kAgainWall_s = 0.05;  // about one period of the lease

}  // namespace

Scheduler::Scheduler(const Experiment& experiment, Phase act) : act_(act), changes_(experiment) {
  for (const NodeInfo& n : nodes()) {
    if (!n.driver) continue;
    subscribe(channels::answer(n.id), this);
    subscribe(channels::device_state(n.id), this);
    if (takes_part(experiment, n.name)) all_drivers_ |= bit(n.id);
  }
  subscribe(channels::kEnable, this);
  subscribe(channels::kSafeStop, this);
  subscribe(channels::kOperatorCommand, this);
}

void Scheduler::start(const Start& start, Time now, Outbox& out) {
  if (phase_ == Phase::kOver) return;
  incarnation_ = start.incarnation;
  enabled_ = false;
  safe_drivers_ = 0;
  paused_ = holding_ = last_layer_ = false;  // a resume is the operator's word to go on
  if (start.resumed() && phase_ != Phase::kGetReady && phase_ != Phase::kStopped) interrupted_ = phase_;
  phase_ = Phase::kGetReady;
  phase_since_ = now;
  // Instruments connect, identify and home in this time.
  out.wake_at(kDeadline, now.after_s(60.0 * experiment().run.time_scale));
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
  if (m.header.incarnation < incarnation_) return;  // of before the resume, which was the operator's reset
  epoch_ = std::max(epoch_, m.enable_epoch);
  if (phase_ != Phase::kGetReady) interrupted_ = phase_;
  phase_ = Phase::kStopped;
  enabled_ = false;
  finish_run(RunOutcome::kStoppedSafely, 3, m.cause, out);
}

void Scheduler::on(const operator_command_t& m, Time now, Outbox& out) {
  if (phase_ == Phase::kOver || !changes_.take(m.command_id)) return;
  // The resume was the operator's word: only changes and acceptances before it still count.
  const bool stale = m.header.incarnation < incarnation_;
  switch (OperatorVerb(m.verb)) {
    case OperatorVerb::kAcceptDoubt:
      doubt_accepted_ = true;
      out.cancel(kOperator);
      return operator_accepted(now, out);
    case OperatorVerb::kPause:
      paused_ = !stale;
      return;
    case OperatorVerb::kContinue:
      return stale ? void() : go_on(now, out);
    case OperatorVerb::kFinishLayer:
      last_layer_ = !stale;
      return stale ? void() : go_on(now, out);
    case OperatorVerb::kStop:
      return;  // safety's
    case OperatorVerb::kSet:
      if (const std::string problem = changes_.set(m.key, m.value); !problem.empty())
        out.report(Severity::kWarning, "the operator's change has no effect: " + problem);
      return;
  }
}

bool Scheduler::holds(const std::string& place, Outbox& out) {
  if (!paused_) return false;
  if (!holding_) out.report(Severity::kNotice, "the print waits " + place + ", as the operator asked");
  holding_ = true;
  out.cancel(kDeadline);
  return true;
}

// The time of the pause is no part of any layer's times.
void Scheduler::go_on(Time now, Outbox& out) {
  paused_ = false;
  if (!std::exchange(holding_, false) || phase_ == Phase::kGetReady || phase_ == Phase::kStopped) return;
  out.report(Severity::kNotice, "the print goes on");
  phase_since_ = now;
  proceed(phase_, now, out);
}

bool Scheduler::ended_by_operator(Phase resume_at, Outbox& out) {
  if (!last_layer_) return false;
  phase_ = resume_at;
  finish_run(RunOutcome::kEndedEarly, 3,
             "layer " + std::to_string(layers_done_) + " was to be the last, as the operator asked", out);
  return true;
}

void Scheduler::try_ready(Time now, Outbox& out) {
  if (phase_ != Phase::kGetReady || !enabled_ || safe_drivers_ != all_drivers_ || pending_) return;
  after_resume(now, out);
}

void Scheduler::wake(TimerId timer, Time now, Outbox& out) {
  if (phase_ == Phase::kOver || phase_ == Phase::kStopped) return;
  if (timer == kAgain) return phase_ == Phase::kGetReady || pending_ ? void() : proceed(phase_, now, out);
  if (timer == kOperator) return finish_run(RunOutcome::kWaitsForOperator, 3, doubt(), out);
  if (phase_ == Phase::kGetReady && pending_ && safe_drivers_ == all_drivers_) {
    // The driver is back and has no record of the command: an act is wholly in doubt; any other phase is
    // begun again.
    if (interrupted_ == act_) {
      answer_t nothing{};
      nothing.outcome = std::int8_t(Outcome::kUnknown);
      nothing.counted = -1;
      nothing.unknown_from = 0;
      nothing.unknown_to = act_size();
      act_answer_ = nothing;
    }
    pending_.reset();
    out.wake_at(kDeadline, now.after_s(30.0 * experiment().run.time_scale));
    return try_ready(now, out);
  }
  const double waited_s = seconds_between(phase_since_, now);
  fail(5, overdue() + " within " + std::to_string(waited_s) + " s", now, out, {waited_s, {}, "s"});
}

std::string Scheduler::overdue() const {
  if (phase_ == Phase::kGetReady) {
    std::string missing;
    for (const NodeInfo& n : nodes())
      if ((all_drivers_ & ~safe_drivers_) & bit(n.id))
        missing += (missing.empty() ? "" : ", ") + std::string(n.name);
    return missing.empty() ? "safety has not granted the lease" : missing + " not SAFE";
  }
  if (pending_)
    return std::string(info(pending_->driver).name) + " has not answered command " +
           std::to_string(pending_->command_id);
  return awaited();
}

void Scheduler::on(const answer_t& m, Time now, Outbox& out) {
  if (!pending_ || m.command_id != pending_->command_id) return;  // repeated, or of an older incarnation
  pending_.reset();
  out.cancel(kDeadline);
  if (phase_ != Phase::kGetReady && phase_ != Phase::kStopped) return take_answer(m, now, out);
  // Answer to the command that the crash or the stop interrupted: kept until the print goes on.
  if (interrupted_ == act_) act_answer_ = m;
  answered_late(m);
  if (phase_ == Phase::kGetReady) out.wake_at(kDeadline, now.after_s(60.0 * experiment().run.time_scale));
  try_ready(now, out);
}

void Scheduler::take_answer(const answer_t& m, Time now, Outbox& out) {
  const Outcome outcome = Outcome(m.outcome);
  // A refused command was not begun. The lease can reach the scheduler before the driver, so the command is
  // sent again.
  if (outcome == Outcome::kRefused && refused_ < kMaxRefusals) {
    ++refused_;
    return out.wake_at(kAgain, now.after_s(kAgainWall_s * experiment().run.time_scale));
  }
  refused_ = 0;
  if (phase_ == act_) act_answer_ = m;
  if (outcome != Outcome::kDone && outcome != Outcome::kReady && !only_counts())
    return fail(m.code, m.node + ": " + m.text, now, out, from_message(m.figure));
  answered(m, now, out);
}

void Scheduler::count_phase_time(Time now) {
  const double s = seconds_between(phase_since_, now);
  phase_since_ = now;
  switch (phase_) {
    case Phase::kArmProfiler:
    case Phase::kScan:
    case Phase::kEndScan:
    case Phase::kAwaitMap:
    case Phase::kLoadScan:
    case Phase::kArmLaser:
    case Phase::kRunScan:
    case Phase::kCollect:
      scan_s_ += s;
      return;
    case Phase::kAwaitPlan:
    case Phase::kAwaitSurface:
    case Phase::kAwaitPaths:
      decide_s_ += s;
      return;
    case Phase::kArmJet:
    case Phase::kPass:
    case Phase::kDisarmJet:
    case Phase::kLoadPath:
    case Phase::kLoadPulses:
    case Phase::kArmValve:
    case Phase::kRunPath:
    case Phase::kDisarmValve:
      deposit_s_ += s;
      return;
    case Phase::kPark:
    case Phase::kCure:
      cure_s_ += s;
      return;
    default:
      return;
  }
}

void Scheduler::fail(int code, const std::string& text, Time now, Outbox& out, const Figure& figure) {
  out.report(Severity::kStop, text, code, figure);
  count_phase_time(now);
  if (phase_ != Phase::kGetReady) interrupted_ = phase_;
  phase_ = Phase::kStopped;
  finish_run(RunOutcome::kStoppedSafely, 3, text, out);
}

bool Scheduler::stopped_by_doubt(const Violation& doubt, int attempt, Phase measure, Time now, Outbox& out) {
  const bool first = !std::exchange(map_doubted_, false);
  if (doubt.empty()) return false;
  if (first && attempt < experiment().process.max_rescans) {
    map_doubted_ = true;
    out.report(Severity::kWarning, doubt.text + "; measuring again", 15, doubt.figure);
    scan_again(now, out);
    return true;
  }
  phase_ = measure;
  fail(15, doubt.text, now, out, doubt.figure);
  return true;
}

void Scheduler::finish_run(RunOutcome outcome, int status, const std::string& reason, Outbox& out) {
  run_end_t end{};
  end.outcome = std::int8_t(outcome);
  end.layers = layers_done_;
  end.reason = reason;
  out.cancel(kDeadline);
  out.cancel(kOperator);
  if (outcome == RunOutcome::kFinished || outcome == RunOutcome::kOutOfTolerance) phase_ = Phase::kOver;
  if (outcome == RunOutcome::kWaitsForOperator || outcome == RunOutcome::kEndedEarly) {
    interrupted_ = phase_;
    phase_ = Phase::kStopped;
  }
  out.send(channels::kRunEnd, end);
  out.finish(status, reason);
}

}  // namespace firn
