#include "procs/scheduler/path_loop.h"

#include <algorithm>
#include <cmath>

#include "firn/path_report_t.hpp"
#include "lcmtypes/convert.h"
#include "procs/scheduler/path_map_check.h"

namespace firn {
namespace {

constexpr int kMaxAttempts = 3;
constexpr int kMaxSlips = 2;

}  // namespace

PathLoop::PathLoop(const Experiment& experiment, slice::PrintPaths paths, double tick_s)
    : Scheduler(experiment, Phase::kRunPath),
      table_first_(experiment.ice.map_table == "on"),
      paths_(table_first_ ? slice::with_table(std::move(paths)) : std::move(paths)),
      tick_s_(tick_s) {
  interrupted_ = Phase::kHeat;
  subscribe(channels::kPathJob, this);
  subscribe(channels::kPulseList, this);
  subscribe(channels::kHeightMap, this);
  subscribe(channels::kControlSurface, this);
  subscribe(channels::kTemperature, this);
}

std::int64_t PathLoop::act_size() const {
  return depositing() ? std::int64_t(task().job.duration_s * 1e6) : 0;
}

int PathLoop::command_layer() const { return depositing() ? task().job.layer : layers_done_; }

std::string PathLoop::place() const {
  if (phase_ == Phase::kLoadScan) return "before the scan of layer " + std::to_string(layers_done_);
  return "before path " + std::to_string(task().job.path) + " of layer " + std::to_string(task().job.layer);
}

std::string PathLoop::awaited() const {
  switch (phase_) {
    case Phase::kWarmUp:
      return "the end effector's tip is not above heater.low_degC";
    case Phase::kAwaitMap:
      return "no height map for scan " + std::to_string(scan_id_);
    case Phase::kAwaitSurface:
      return "no control surface for map " + std::to_string(map_id_);
    default:
      return "no paths that answer map " + std::to_string(map_id_);
  }
}

std::string PathLoop::doubt() const {
  return "a path of layer " + std::to_string(depositing() ? task().job.layer : layers_done_) +
         " is in doubt and the open loop cannot correct it: look at the part, then resume with "
         "--accept-doubt";
}

bool PathLoop::waits_for_operator() const {
  return in_doubt_ && experiment().control.scheme == "open_loop" && !doubt_accepted_;
}

void PathLoop::operator_accepted(Time now, Outbox& out) {
  if (phase_ == Phase::kAwaitOperator) next_path(now, out);
}

// A crash may have left the arm anywhere, and without power: the arm goes home first. A phase that could
// deposit twice is settled; any other phase is begun again.
void PathLoop::after_resume(Time now, Outbox& out) {
  untouched_ = false;
  switch (interrupted_) {
    case Phase::kHeat:
    case Phase::kWarmUp:
    case Phase::kHoming:
      return proceed(Phase::kHeat, now, out);  // with the goal that homing had
    case Phase::kLoadPulses:
      after_homing_ = Phase::kLoadPath;
      break;
    case Phase::kArmValve: {  // the arm has not moved, but the valve may have been armed: it is asked
      answer_t none{};
      none.outcome = std::int8_t(Outcome::kNone);
      act_answer_ = none;
      attempt_ = 0;
      after_homing_ = Phase::kDisarmValve;
      break;
    }
    case Phase::kRunPath:
      after_homing_ = Phase::kDisarmValve;
      break;
    case Phase::kLoadScan:
    case Phase::kArmLaser:
    case Phase::kRunScan:
    case Phase::kCollect:
      ++scan_attempt_;
      scan_at_ = 0;
      after_homing_ = Phase::kLoadScan;
      break;
    default:
      after_homing_ = interrupted_;
  }
  proceed(Phase::kHeat, now, out);
}

void PathLoop::answered_late(const answer_t& m) {
  if (interrupted_ == Phase::kDisarmValve) late_count_ = m;
}

void PathLoop::answered(const answer_t& m, Time now, Outbox& out) {
  switch (phase_) {
    case Phase::kHeat:
      return proceed(Phase::kWarmUp, now, out);
    case Phase::kHoming:
      return proceed(after_homing_, now, out);
    case Phase::kLoadPath:
      return proceed(Phase::kLoadPulses, now, out);
    case Phase::kLoadPulses:
      return proceed(Phase::kArmValve, now, out);
    case Phase::kArmValve:
      return proceed(Phase::kRunPath, now, out);
    case Phase::kRunPath:
      return proceed(Phase::kDisarmValve, now, out);
    case Phase::kDisarmValve:
      return settle_list(m, now, out);
    case Phase::kRaise:
      return measure_again(now, out);
    case Phase::kLoadScan:
      return proceed(Phase::kArmLaser, now, out);
    case Phase::kArmLaser:
      return proceed(Phase::kRunScan, now, out);
    case Phase::kRunScan:
      return proceed(Phase::kCollect, now, out);
    case Phase::kCollect:
      ++scan_at_;
      return next_scan_path(now, out);
    default:
      return;
  }
}

// A list was run, was not run, or its outcome is unknown. The valve's answer is a count for any outcome;
// refused: the valve has no record of an armed list.
void PathLoop::settle_list(const answer_t& count, Time now, Outbox& out) {
  late_count_.reset();
  if (!act_answer_) return next_path(now, out);
  const answer_t m = *act_answer_;
  act_answer_.reset();
  const Outcome outcome = Outcome(m.outcome);
  const bool known = Outcome(count.outcome) != Outcome::kUnknown &&
                     Outcome(count.outcome) != Outcome::kRefused && count.counted >= 0;
  const std::int64_t pulses = known ? count.counted : -1;
  const std::string path = "path " + std::to_string(task().job.path);
  // Refused or kNone: the arm has not moved, so the valve has had no signal. If the valve counted pulses
  // nevertheless, material was deposited at an unknown place. A valve that was reset while it was armed
  // cannot say it, and never arms that list again.
  const bool nothing = (outcome == Outcome::kNone || outcome == Outcome::kRefused) &&
                       (pulses == 0 || Outcome(count.outcome) == Outcome::kRefused);
  if (nothing && ++attempt_ < kMaxAttempts) return proceed(Phase::kLoadPath, now, out);
  if (nothing)
    return fail(5, path + " did not begin in " + std::to_string(kMaxAttempts) + " attempts", now, out);
  outcome_ = m.outcome;
  attempt_ = 0;
  pulses_counted_ = pulses < 0 || pulses_counted_ < 0 ? -1 : pulses_counted_ + pulses;
  if (outcome != Outcome::kDone || !known) {
    if (outcome != Outcome::kFailed) outcome_ = int(Outcome::kUnknown);
    closed_ = in_doubt_ = true;
    doubt_accepted_ = false;
    measured_s_ = kNotMeasured;
  } else {
    const std::int64_t listed = task().list_pulses[std::size_t(list_)];
    if (pulses < listed) {
      outcome_ = int(Outcome::kFailed);
      if (experiment().control.scheme == "open_loop") {  // nothing will correct the gap
        closed_ = in_doubt_ = true;
        doubt_accepted_ = false;
      }
      out.report(
          Severity::kWarning,
          path + ": the valve fired " + std::to_string(pulses) + " of " + std::to_string(listed) + " pulses",
          3, {double(pulses), double(listed)});
    }
    measured_s_ += double(m.counted) * 1e-6;
    const double slip_s = std::abs(double(m.counted - m.expected)) * 1e-6;
    slips_ = slip_s > experiment().ice.max_time_slip_s ? slips_ + 1 : 0;
    if (slips_ >= kMaxSlips)
      return fail(7,
                  path + " took " + std::to_string(double(m.counted) * 1e-6) + " s instead of " +
                      std::to_string(double(m.expected) * 1e-6) +
                      " s, as the one before: its pulses lie elsewhere",
                  now, out, {slip_s, experiment().ice.max_time_slip_s, "s", "ice.max_time_slip_s"});
  }
  ++list_;
  next_list(now, out);
}

// A list without a pulse, of a path shorter than a drop, is not run.
void PathLoop::next_list(Time now, Outbox& out) {
  while (!closed_ && list_ < task().job.lists && task().list_pulses[std::size_t(list_)] == 0) ++list_;
  if (!closed_ && list_ < task().job.lists) return proceed(Phase::kLoadPath, now, out);
  report(out);
  ++at_;
  next_path(now, out);
}

void PathLoop::report(Outbox& out) {
  const path_job_t& job = task().job;
  path_report_t r{};
  r.path = job.path;
  r.batch = job.batch;
  r.layer = job.layer;
  r.attempt = 0;
  r.material = job.material;
  r.kind = job.kind;
  r.outcome = std::int8_t(outcome_);
  r.pulses_commanded = job.pulses;
  r.pulses_counted = pulses_counted_;
  r.volume_mm3 = job.volume_mm3;
  r.planned_s = job.duration_s;
  r.measured_s = measured_s_;
  r.begin_utime_us = begun_.us;
  r.contour_max_mm = r.contour_rms_mm = r.following_max_mm = r.lag_max_s = r.switch_max_mm = r.offset_rms_mm =
      std::numeric_limits<double>::quiet_NaN();
  out.send(channels::kPathReport, r);
  pulses_interval_ += std::max<std::int64_t>(0, pulses_counted_);
  pulses_total_ += std::max<std::int64_t>(0, pulses_counted_);
}

void PathLoop::next_path(Time now, Outbox& out) {
  if (waits_for_operator()) return proceed(Phase::kAwaitOperator, now, out);
  list_ = attempt_ = 0;
  outcome_ = int(Outcome::kDone);
  closed_ = false;
  pulses_counted_ = 0;
  measured_s_ = 0.0;
  if (depositing()) return next_list(now, out);
  for (const PathTask& t : deposition_) layers_done_ = std::max(layers_done_, int(t.job.layer));
  scan_ = std::move(next_scan_);
  next_scan_.clear();
  scan_attempt_ = 0;
  scan_at_ = 0;
  next_scan_path(now, out);
}

void PathLoop::next_scan_path(Time now, Outbox& out) {
  proceed(scan_at_ < scan_.size() ? Phase::kLoadScan : Phase::kAwaitMap, now, out);
}

void PathLoop::measure_again(Time now, Outbox& out) {
  ++scan_attempt_;
  scan_at_ = 0;
  next_scan_path(now, out);
}

void PathLoop::on(const path_job_t& m, Time now, Outbox& out) {
  if (!m.text.empty() && phase_ != Phase::kStopped && phase_ != Phase::kOver) {
    batch_.add(m);
    return fail(8, "PATH_JOB: " + batch_.refusal(), now, out);
  }
  batch_.add(m);
  if (phase_ == Phase::kAwaitPaths) act_on_batch(now, out);
}

void PathLoop::on(const pulse_list_t& m, Time now, Outbox& out) {
  batch_.add(m);
  if (phase_ == Phase::kAwaitPaths) act_on_batch(now, out);
}

void PathLoop::act_on_batch(Time now, Outbox& out) {
  if (!batch_.complete() || batch_.number() <= batch_done_ || batch_.map_id() != map_id_) return;
  out.cancel(kDeadline);
  std::vector<PathTask> deposition = batch_.deposition(), measurement = batch_.measurement();
  const std::string what = "batch " + std::to_string(batch_.number());
  const bool of_table = table_first_ && map_id_ == 0;
  if (deposition.empty() != of_table || measurement.empty())
    return fail(8,
                what + (measurement.empty() ? " is not measured"
                        : of_table          ? " deposits before the table is measured"
                                            : " deposits nothing"),
                now, out);
  for (const PathTask& t : newest_.size() ? deposition : std::vector<PathTask>()) {
    const Violation why = scrape(t.job, newest_, experiment().ice.clearance_mm);
    if (why.empty()) continue;
    const std::string text =
        "path " + std::to_string(t.job.path) + " of layer " + std::to_string(t.job.layer) + ": " + why.text;
    if (raised_) return fail(6, text, now, out, why.figure);
    raised_ = true;
    out.report(Severity::kWarning, text + "; raising and measuring again", 6, why.figure);
    return proceed(Phase::kRaise, now, out);
  }
  raised_ = false;
  batch_done_ = batch_.number();
  deposition_ = std::move(deposition);
  next_scan_ = std::move(measurement);
  at_ = 0;
  pulses_interval_ = 0;
  next_path(now, out);
}

// A map can overtake the laser's last answer, or arrive while the lab gets ready again: it is kept until its
// turn.
void PathLoop::on(const height_map_t& m, Time now, Outbox& out) {
  if (m.layer != layers_done_ || m.attempt != scan_attempt_ || m.map_id == map_id_) return;
  map_ = m;
  if (phase_ == Phase::kAwaitMap) act_on_map(now, out);
}

void PathLoop::act_on_map(Time now, Outbox& out) {
  if (!map_ || map_->layer != layers_done_ || map_->attempt != scan_attempt_) return;
  const height_map_t m = std::move(*map_);
  map_.reset();
  out.cancel(kDeadline);
  const double needed = experiment().process.min_measured_fraction;
  if (m.measured_fraction < needed) {
    const std::string what = "height map of layer " + std::to_string(m.layer) + ": the laser has measured " +
                             std::to_string(m.measured_fraction) + " of it; " + std::to_string(needed) +
                             " is needed";
    const Figure figure{m.measured_fraction, needed, "", "process.min_measured_fraction"};
    if (scan_attempt_ >= experiment().process.max_rescans) {
      phase_ = Phase::kLoadScan;  // a resume continues here
      const bool deposited = layers_done_ > 0;
      return fail(
          13, what + (deposited ? "; the surface may be beyond the laser's range: a valve stays open?" : ""),
          now, out, figure);
    }
    out.report(Severity::kWarning, what + "; measuring again", 13, figure);
    count_phase_time(now);
    return measure_again(now, out);
  }
  if (doubted(m, now, out)) return;
  const Violation leak =
      untouched_ ? rise_without_command(experiment(), layers_done_, newest_, height_of(m)) : Violation();
  if (!leak.empty()) {
    phase_ = Phase::kLoadScan;  // a resume measures first
    return fail(12, leak.text, now, out, leak.figure);
  }
  map_id_ = m.map_id;
  if (m.layer > mapped_layers_) below_ = std::move(newest_);
  newest_ = height_of(m);
  untouched_ = true;
  mapped_layers_ = m.layer;
  const ValveDoubt valve =
      in_doubt_ ? ValveDoubt()
                : disturbed_valve(experiment(), paths_, m.layer, layers_laid(m.layer), newest_, below_);
  // Debris rises once, which interlock 6 sees; a valve that stays open does so in every interval.
  const bool again = much_layer_ != 0 && much_layer_ < m.layer;
  much_layer_ = !valve.much ? 0 : much_layer_ == 0 ? int(m.layer) : much_layer_;
  dry_ = m.layer == dry_told_ || (valve.much && !again) ? Violation() : valve.violation;
  in_doubt_ = false;
  count_phase_time(now);
  if (m.layer > 0) {  // the table has no error; the time that its measurement took is the first interval's
    publish_metrics(m, out);
    deposit_s_ = scan_s_ = decide_s_ = 0;
  }
  proceed(Phase::kAwaitSurface, now, out);
}

void PathLoop::on(const control_surface_t& m, Time now, Outbox& out) {
  if (m.layer != layers_done_ || m.attempt != scan_attempt_) return;
  surface_ = m;
  if (phase_ == Phase::kAwaitSurface) act_on_surface(now, out);
}

void PathLoop::act_on_surface(Time now, Outbox& out) {
  if (!surface_ || surface_->map_id != map_id_) return;
  const control_surface_t m = std::move(*surface_);
  surface_.reset();
  out.cancel(kDeadline);
  if (PlanDecision(m.decision) == PlanDecision::kEnd) {
    Violation missed = dry_;
    if (missed.empty() && m.saturated_fraction > experiment().ice.saturated_share)
      missed = {"the last map asks for more correction than there is on " +
                    std::to_string(m.saturated_fraction) + " of its cells: mean error " +
                    std::to_string(m.mean_error_mm) + " mm, RMS " + std::to_string(m.rms_mm) + " mm",
                {m.saturated_fraction, experiment().ice.saturated_share, "", "ice.saturated_share"}};
    if (missed.empty()) return finish_run(RunOutcome::kFinished, 0, m.reason, out);
    out.report(Severity::kWarning, missed.text, 12, missed.figure);
    return finish_run(RunOutcome::kOutOfTolerance, 1,
                      m.reason + ", but it is not what was wanted: " + missed.text, out);
  }
  if (PlanDecision(m.decision) == PlanDecision::kStop)
    return stop_for_operator("controller: ", {m.reason}, out);
  if (!dry_.empty()) return stop_for_operator("", dry_, out);
  if (ended_by_operator(Phase::kLoadScan, out)) return;
  proceed(Phase::kAwaitPaths, now, out);
}

int PathLoop::layers_laid(int layer) const {
  int layers = 0;
  for (const PathTask& t : deposition_) layers = std::max(layers, layer - int(t.job.layer) + 1);
  return layers;
}

bool PathLoop::doubted(const height_map_t& m, Time now, Outbox& out) {
  if (mapped_layers_ > 0 || in_doubt_) return false;
  const FirstMapDoubt doubt = doubt_of_first_map(experiment(), paths_, m, newest_);
  if (!doubt.warning.empty()) out.report(Severity::kWarning, doubt.warning.text, 15, doubt.warning.figure);
  return stopped_by_doubt(doubt.stop, scan_attempt_, Phase::kLoadScan, now, out);
}

void PathLoop::scan_again(Time now, Outbox& out) {
  count_phase_time(now);
  measure_again(now, out);
}

void PathLoop::stop_for_operator(const std::string& who, const Violation& reason, Outbox& out) {
  dry_told_ = layers_done_;
  phase_ = Phase::kLoadScan;  // the surface may not be as it was when somebody has been at the lab
  out.report(Severity::kWarning, who + reason.text, 12, reason.figure);
  finish_run(RunOutcome::kWaitsForOperator, 3, reason.text, out);
}

void PathLoop::on(const temperature_t& m, Time now, Outbox& out) {
  temperature_ = m;
  act_on_temperature(now, out);
}

// (b) alone keeps the valves from freezing when (a) fails [2.3.3]; the tip's thermocouple decides.
void PathLoop::act_on_temperature(Time now, Outbox& out) {
  if (!temperature_ || phase_ == Phase::kGetReady || phase_ == Phase::kStopped || phase_ == Phase::kOver)
    return;
  const temperature_t& t = *temperature_;
  const bool tip_failed = t.fault[0] != 0, window_failed = t.fault[1] != 0;
  if (tip_failed && window_failed)
    return fail(10, "heaters (a) and (b) have both failed: the valves freeze", now, out);
  const bool warm = std::isfinite(t.degC[0]) ? t.degC[0] >= experiment().heater.low_degC : !window_failed;
  if (phase_ == Phase::kWarmUp) {
    if (!warm) return;
    out.cancel(kDeadline);
    return proceed(Phase::kHoming, now, out);
  }
  if (!warm && phase_ != Phase::kHeat)
    return fail(10,
                "the end effector's tip is at " + std::to_string(t.degC[0]) +
                    " degC, below heater.low_degC = " + std::to_string(experiment().heater.low_degC) +
                    ": the valves freeze",
                now, out, {t.degC[0], experiment().heater.low_degC, "degC", "heater.low_degC"});
  if (tip_failed && !one_heater_)
    out.report(Severity::kWarning, "heater (a) has failed; (b) alone keeps the valves warm", 10);
  one_heater_ = tip_failed;
}

}  // namespace firn
