#include "procs/scheduler/droplet_loop.h"

#include <algorithm>

#include "core/grid/outline.h"
#include "lcmtypes/convert.h"
#include "procs/scheduler/rise_check.h"
#include "procs/scheduler/scrape_check.h"
#include "procs/scheduler/sensor_check.h"

namespace firn {
namespace {

constexpr int kMostHalvings = 4;  // of the scan's speed

}  // namespace

DropletLoop::DropletLoop(const Experiment& experiment, HeightMap target, Mask mask)
    : ScanLoop(experiment, Phase::kPass, std::move(target), std::move(mask)),
      two_jets_(has_two_jets(experiment)),
      inside_(inside_of(mask_)),
      rim_(mask_) {
  for (std::size_t c = 0; c < rim_.size(); ++c)
    if (inside_.cells[c]) rim_.cells[c] = 0;
  subscribe(channels::kLayerPlan, this);
  if (firn::on(experiment.camera.use)) subscribe(channels::kDropletSweep, this);
}

std::string DropletLoop::doubt() const {
  return "droplets of layer " + std::to_string(job_.layer()) +
         " are in doubt and the open loop cannot correct them: look at the part, then resume with "
         "--accept-doubt";
}

std::string DropletLoop::place() const {
  if (job_.finished()) return "before the scan of layer " + std::to_string(layers_done_);
  return "before layer " + std::to_string(job_.layer()) + ", pass " + std::to_string(job_.pass());
}

std::string DropletLoop::awaited() const {
  if (phase_ == Phase::kAwaitSweep) return "no droplet sweep " + std::to_string(sweep_id_);
  return ScanLoop::awaited();
}

void DropletLoop::answered_late(const answer_t& m) {
  if (interrupted_ == Phase::kCure && Outcome(m.outcome) == Outcome::kDone) interrupted_ = Phase::kArmJet;
}

// The phase in which the crash came is entered again, except where that could fire a droplet twice.
void DropletLoop::after_resume(Time now, Outbox& out) {
  switch (interrupted_) {
    case Phase::kArmProfiler:
    case Phase::kScan:
    case Phase::kEndScan:
      return scan_again(now, out);
    case Phase::kPass:
      return proceed(Phase::kDisarmJet, now, out);  // with act_answer_, whatever it says
    // The stage has homed since, or was moved by hand (I9).
    case Phase::kCure:
      return proceed(experiment().process.park_again == "on" ? Phase::kPark : Phase::kCure, now, out);
    case Phase::kPurging:
    case Phase::kEndPurge:
    case Phase::kJetting:
    case Phase::kPictures:
    case Phase::kEndJetting:
    case Phase::kAwaitSweep:
      return proceed(Phase::kToCamera, now, out);
    default:
      return proceed(interrupted_, now, out);
  }
}

void DropletLoop::answered(const answer_t& m, Time now, Outbox& out) {
  if (phase_ == Phase::kHoming && volume_first() && watched_layer_ == 0)
    return proceed(Phase::kToCamera, now, out);
  if (watch_answered(now, out) || scan_answered(now, out)) return;
  switch (phase_) {
    case Phase::kArmJet:
      return proceed(Phase::kPass, now, out);
    case Phase::kPass:
      return proceed(Phase::kDisarmJet, now, out);
    case Phase::kDisarmJet:
      if (Outcome(m.outcome) == Outcome::kRefused) return fail(m.code, m.node + ": " + m.text, now, out);
      settle_pass(m, out);
      return proceed(job_.cure_due() ? Phase::kPark : Phase::kArmJet, now, out);
    case Phase::kPark:
      return proceed(Phase::kCure, now, out);
    case Phase::kCure:
      return proceed(Phase::kArmJet, now, out);  // which scans when no pass is left
    default:
      return;
  }
}

void DropletLoop::settle_pass(const answer_t& jet, Outbox& out) {
  if (!act_answer_) return;
  const deposition_report_t report = job_.settle(*act_answer_, jet);
  act_answer_.reset();
  drops_total_ += report.unknown_from;
  if (job_.in_doubt()) doubt_accepted_ = false;
  out.send(channels::kDepositionReport, report);
}

void DropletLoop::act_on_map(Time now, Outbox& out) {
  if (!map_) return;
  const height_map_t m = std::move(*map_);
  map_.reset();
  out.cancel(kDeadline);
  if (from_message(m.grid) != experiment().grid)
    return fail(0, "HEIGHT_MAP: grid is not the experiment's", now, out);
  if (rejected(m, now, out)) return;
  if (doubted(m, now, out) || stopped_by_rise(m, now, out) || stopped_by_height(m, now, out)) return;
  map_id_ = m.map_id;
  publish_metrics(m, now, out);
  proceed(Phase::kAwaitPlan, now, out);
}

bool DropletLoop::rejected(const height_map_t& m, Time now, Outbox& out) {
  const int lost = m.rows_expected - m.rows_received;
  rows_lost_ = std::min(1'000'000, rows_lost_ + lost);
  const bool many = lost > experiment().process.max_lost_rows_share * m.rows_expected;
  const double needed = experiment().process.min_measured_fraction;
  const bool little = m.measured_fraction < needed;
  if (!many && !little) return false;
  std::string what = "height map of layer " + std::to_string(m.layer);
  if (many)
    what += " lacks " + std::to_string(lost) + " of " + std::to_string(m.rows_expected) +
            " rows of its scan" + (little ? " and" : "");
  if (little)
    what += " measures " + std::to_string(m.measured_fraction) + " of the grid; " + std::to_string(needed) +
            " is needed";
  if (scan_attempt_ < experiment().process.max_rescans) {
    if (many && slower_ < kMostHalvings) ++slower_;
    send_fault(
        Severity::kWarning, 13,
        what + "; measuring again" + (many ? " at " + std::to_string(scan_speed_mm_s()) + " mm/s" : ""), out);
    scan_again(now, out);
    return true;
  }
  if (little) {
    phase_ = Phase::kArmProfiler;  // a resume continues here
    fail(13, what, now, out);
    return true;
  }
  send_fault(Severity::kWarning, 13, what + "; the layer is decided without them", out);
  return false;
}

// Interlock 15.
bool DropletLoop::doubted(const height_map_t& m, Time now, Outbox& out) {
  if (m.layer > 1 || experiment().control.scheme == "registration") return false;
  const LaserProfilerConfig& sensor = experiment().laser_profiler;
  HeightMap height = measured_height_of(m);
  std::string doubt;
  if (m.layer == 0) {
    doubt = check_bare(height, sensor.bias_limit_mm,
                       {"the bare table", "the profiler's zero or the table's height",
                        "set the profiler to zero on the bare table"});
    if (doubt.empty()) bare_ = std::move(height);
  } else if (experiment().control.scheme == "pattern") {  // scattered cells have no outline
    bare_ = HeightMap();
  } else if (bare_.size() == height.size() && job_.finished() && !job_.in_doubt() && job_.layer() == 1) {
    for (std::size_t c = 0; c < height.size(); ++c) height.cells[c] -= bare_.cells[c];
    Mask laid(experiment().grid);
    for (std::size_t c = 0; c < laid.size(); ++c) laid.cells[c] = job_.plan().cells[c] > 0;
    doubt = check_outline(height, laid, {}, sensor.offset_limit_mm,
                          {"the first layer", "laser_profiler.offset_y_mm, the profiler's x or the nozzle",
                           "measure the place of the profiler's line against a printed mark"});
    if (doubt.empty()) bare_ = HeightMap();
  }
  return stopped_by_doubt(doubt, scan_attempt_, Phase::kArmProfiler, now, out);
}

// Interlock 12. After the stop somebody has been at the nozzle: the next map is where the comparison begins.
bool DropletLoop::stopped_by_rise(const height_map_t& m, Time now, Outbox& out) {
  HeightMap height = measured_height_of(m);
  const bool whole = job_.finished() && !job_.in_doubt() && job_.layer() == m.layer;
  const std::string what = whole && below_.size() && below_layer_ == m.layer - 1
                               ? check_rise(experiment(), below_, height, job_.plan(), job_.materials())
                               : "";
  below_ = what.empty() ? std::move(height) : HeightMap();
  below_layer_ = m.layer;
  if (what.empty()) return false;
  phase_ = Phase::kArmProfiler;  // a resume continues here
  fail(12, "layer " + std::to_string(m.layer) + ": " + what, now, out);
  return true;
}

// Every pass and every scan sweeps the whole grid with the nozzle at one height.
bool DropletLoop::stopped_by_height(const height_map_t& m, Time now, Outbox& out) {
  const double needed_mm = experiment().process.nozzle_clearance_mm;
  const std::string what =
      needed_mm > 0.0 ? scrape(height_of(m), experiment().process.nozzle_gap_mm, needed_mm) : std::string();
  if (what.empty()) return false;
  const std::string text = "layer " + std::to_string(m.layer) + ": " + what;
  if (scan_attempt_ < experiment().process.max_rescans) {
    send_fault(Severity::kWarning, 6, text + "; measuring again", out);
    scan_again(now, out);
    return true;
  }
  phase_ = Phase::kArmProfiler;  // a resume continues here
  fail(6, text, now, out);
  return true;
}

// A plan too can arrive before the scheduler has acted on the map that it answers.
void DropletLoop::on(const layer_plan_t& m, Time now, Outbox& out) {
  if (m.attempt != scan_attempt_ || m.layer != layers_done_ + 1) return;
  plan_ = m;
  if (phase_ == Phase::kAwaitPlan) act_on_plan(now, out);
}

void DropletLoop::act_on_plan(Time now, Outbox& out) {
  if (!plan_ || plan_->map_id != map_id_ || waits_for_operator()) return;
  const layer_plan_t m = *plan_;
  out.cancel(kDeadline);
  if (PlanDecision(m.decision) == PlanDecision::kEnd)
    return finish_run(RunOutcome::kFinished, 0, m.reason, out);
  if (PlanDecision(m.decision) == PlanDecision::kStop) {
    phase_ =
        Phase::kArmProfiler;  // a resume measures and asks again: somebody was at the lab, or set an option
    return finish_run(RunOutcome::kWaitsForOperator, 3, m.reason, out);
  }
  if (from_message(m.grid) != experiment().grid)
    return fail(0, "LAYER_PLAN: grid is not the experiment's", now, out);
  if (m.layer > experiment().control.max_layers) {
    phase_ = Phase::kArmProfiler;
    return finish_run(
        RunOutcome::kWaitsForOperator, 3,
        "control.max_layers = " + std::to_string(experiment().control.max_layers) + " is reached", out);
  }
  if (ended_by_operator(Phase::kArmProfiler, out)) return;
  plan_.reset();
  objective_mm_ = m.objective_mm;
  iterations_ = m.iterations;
  if (two_jets_ && m.n_material == 0)
    return fail(0, "LAYER_PLAN: layer " + std::to_string(m.layer) + " names no inks, and the lab has two",
                now, out);
  try {
    job_ = LayerJob(m, two_jets_ ? materials_of(m) : MaterialMap{}, experiment().process.sub_patterns);
  } catch (const std::invalid_argument& problem) {
    return fail(0, std::string("LAYER_PLAN: ") + problem.what(), now, out);
  }
  proceed(watch_due() ? Phase::kToCamera : Phase::kArmJet, now, out);
}

bool DropletLoop::waits_for_operator() const {
  return job_.in_doubt() && experiment().control.scheme == "open_loop" && !doubt_accepted_;
}

}  // namespace firn
