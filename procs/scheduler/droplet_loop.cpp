#include "procs/scheduler/droplet_loop.h"

#include <algorithm>
#include <cmath>

#include "config/nozzles.h"
#include "core/grid/outline.h"
#include "drivers/stage/raster.h"
#include "firn/jet_command_t.hpp"
#include "firn/lamp_command_t.hpp"
#include "firn/stage_command_t.hpp"
#include "lcmtypes/convert.h"
#include "procs/scheduler/scrape_check.h"
#include "procs/scheduler/sensor_check.h"

namespace firn {
namespace {

constexpr int kMaxHalvings = 4;  // of the scan's speed

double extent_mm(int n, double pitch_mm) { return (n + 1) * pitch_mm; }

}  // namespace

DropletLoop::DropletLoop(const Experiment& experiment, HeightMap target, Mask mask)
    : ScanLoop(experiment, Phase::kPass, std::move(target), std::move(mask)),
      two_jets_(has_two_jets(experiment)),
      places_(experiment.actuation),
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
  return "before layer " + std::to_string(job_.layer()) + ", pass " + std::to_string(job_.pass() + 1);
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
      if (Outcome(m.outcome) == Outcome::kRefused)
        return fail(m.code, m.node + ": " + m.text, now, out, from_message(m.figure));
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
  // Droplets beside the centres come as fast as the jet follows.
  const double most_hz = job_.offsets().cells.empty()
                             ? experiment().process.pass_speed_mm_s / job_.fires().spec.pitch_x_mm
                             : jets_rate_hz(experiment());
  const deposition_report_t report = job_.settle(*act_answer_, jet, most_hz);
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
  const Figure figure = little
                            ? Figure{m.measured_fraction, needed, "", "process.min_measured_fraction"}
                            : Figure{double(lost) / m.rows_expected, experiment().process.max_lost_rows_share,
                                     "", "process.max_lost_rows_share"};
  std::string what = "height map of layer " + std::to_string(m.layer);
  if (many)
    what += " lacks " + std::to_string(lost) + " of " + std::to_string(m.rows_expected) +
            " rows of its scan" + (little ? " and" : "");
  if (little)
    what += " measures " + std::to_string(m.measured_fraction) + " of the grid; " + std::to_string(needed) +
            " is needed";
  if (scan_attempt_ < experiment().process.max_rescans) {
    if (many && slower_ < kMaxHalvings) ++slower_;
    out.report(
        Severity::kWarning,
        what + "; measuring again" + (many ? " at " + std::to_string(scan_speed_mm_s()) + " mm/s" : ""), 13,
        figure);
    scan_again(now, out);
    return true;
  }
  if (little) {
    phase_ = Phase::kArmProfiler;  // a resume continues here
    fail(13, what, now, out, figure);
    return true;
  }
  out.report(Severity::kWarning, what + "; the layer is decided without them", 13, figure);
  return false;
}

HeightMap DropletLoop::on_part(HeightMap height) const {
  for (std::size_t c = 0; c < height.size(); ++c)
    if (!mask_.cells[c]) height.cells[c] = kNotMeasured;
  return height;
}

// Interlock 15.
bool DropletLoop::doubted(const height_map_t& m, Time now, Outbox& out) {
  if (m.layer > 1 || experiment().control.scheme == "registration") return false;
  const LaserProfilerConfig& sensor = experiment().laser_profiler;
  HeightMap height = measured_height_of(m);
  Violation doubt;
  if (m.layer == 0) {
    SensorWords words{"the bare table",
                      "something lies on it, or the profiler's zero or the table's height is another",
                      "clear the table, or set the profiler to zero on it", "laser_profiler.bias_limit_mm"};
    doubt = check_bare(height, sensor.bias_limit_mm, words);
    if (doubt.empty()) {  // a small thing does not show in the mean of a large table
      words.what = "the part's place on the bare table";
      doubt = check_bare(on_part(height), sensor.bias_limit_mm, words);
    }
    if (doubt.empty()) bare_ = std::move(height);
  } else if (experiment().control.scheme == "pattern") {  // scattered cells have no outline
    bare_ = HeightMap();
  } else if (bare_.size() == height.size() && job_.finished() && !job_.in_doubt() && job_.layer() == 1) {
    for (std::size_t c = 0; c < height.size(); ++c) height.cells[c] -= bare_.cells[c];
    Mask laid(experiment().grid);
    for (std::size_t c = 0; c < laid.size(); ++c) laid.cells[c] = job_.plan().cells[c] > 0;
    doubt = check_outline(height, laid, {}, sensor.offset_limit_mm,
                          {"the first layer", "laser_profiler.offset_y_mm, the profiler's x or the nozzle",
                           "measure the place of the profiler's line against a printed mark",
                           "laser_profiler.offset_limit_mm"});
    if (doubt.empty()) bare_ = HeightMap();
  }
  return stopped_by_doubt(doubt, scan_attempt_, Phase::kArmProfiler, now, out);
}

// Interlock 12. After the stop somebody has been at the nozzle: the next map is where the comparison begins.
bool DropletLoop::stopped_by_rise(const height_map_t& m, Time now, Outbox& out) {
  HeightMap height = measured_height_of(m);
  const bool whole = job_.finished() && !job_.in_doubt() && job_.layer() == m.layer;
  const Violation what = whole && below_.size() && below_layer_ == m.layer - 1
                             ? rise_.check(experiment(), {below_, height, below_std_mm_, m.noise_std_mm,
                                                          job_.plan(), job_.materials(), job_.offsets()})
                             : Violation();
  below_ = what.empty() ? std::move(height) : HeightMap();
  below_layer_ = m.layer;
  below_std_mm_ = m.noise_std_mm;
  if (what.empty()) return false;
  rise_.restart();
  phase_ = Phase::kArmProfiler;  // a resume continues here
  fail(12, "layer " + std::to_string(m.layer) + ": " + what.text, now, out, what.figure);
  return true;
}

// Every pass and every scan sweeps the whole grid with the nozzle at one height.
bool DropletLoop::stopped_by_height(const height_map_t& m, Time now, Outbox& out) {
  const double needed_mm = experiment().process.nozzle_clearance_mm;
  const Violation what =
      needed_mm > 0.0 ? scrape(height_of(m), lowest_nozzle_mm(experiment()), needed_mm) : Violation();
  if (what.empty()) return false;
  const std::string text = "layer " + std::to_string(m.layer) + ": " + what.text;
  if (scan_attempt_ < experiment().process.max_rescans) {
    out.report(Severity::kWarning, text + "; measuring again", 6, what.figure);
    scan_again(now, out);
    return true;
  }
  phase_ = Phase::kArmProfiler;  // a resume continues here
  fail(6, text, now, out, what.figure);
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
        "control.max_layers = " + std::to_string(experiment().control.max_layers) +
            " is reached; if the part needs more, resume with a larger --set control.max_layers=N",
        out);
  }
  if (ended_by_operator(Phase::kArmProfiler, out)) return;
  plan_.reset();
  objective_mm_ = m.objective_mm;
  iterations_ = m.iterations;
  if (two_jets_ && m.n_material == 0)
    return fail(0, "LAYER_PLAN: layer " + std::to_string(m.layer) + " names no inks, and the lab has two",
                now, out);
  try {
    job_ =
        LayerJob(m, two_jets_ ? materials_of(m) : MaterialMap{}, experiment().process.sub_patterns, places_);
  } catch (const std::invalid_argument& problem) {
    return fail(0, std::string("LAYER_PLAN: ") + problem.what(), now, out);
  }
  proceed(watch_due() ? Phase::kToCamera : Phase::kArmJet, now, out);
}

bool DropletLoop::waits_for_operator() const {
  return job_.in_doubt() && experiment().control.scheme == "open_loop" && !doubt_accepted_;
}

void DropletLoop::proceed(Phase next, Time now, Outbox& out) {
  count_phase_time(now);
  if (next == Phase::kArmJet && job_.finished()) {
    if (layers_done_ != job_.layer()) {
      layers_done_ = job_.layer();
      scan_attempt_ = 0;
    }
    next = Phase::kArmProfiler;
  }
  phase_ = next;
  const bool nothing_wet = next == Phase::kArmProfiler || (next == Phase::kArmJet && job_.cure_due());
  if (nothing_wet && holds(place(), out)) return;
  if (enter_watch(next, now, out) || enter_scan(next, now, out)) return;
  switch (next) {
    case Phase::kArmJet:
      return send_jet(job_.small() ? JetVerb::kArmSmall : JetVerb::kArm, now, out);
    case Phase::kPass:
      return send_pass(now, out);
    case Phase::kDisarmJet:
      return send_jet(JetVerb::kDisarm, now, out);
    case Phase::kPark:
      return send_move(experiment().process.park_x_mm, experiment().process.park_y_mm, now, out);
    case Phase::kCure:
      return send_exposure(now, out);
    default:
      return;
  }
}

void DropletLoop::send_pass(Time now, Outbox& out) {
  const DropletPattern& fires = job_.fires();
  const bool b = job_.material() == Material::kB;
  const Experiment& e = experiment();
  stage_command_t c{};
  c.verb = std::int8_t(StageVerb::kPass);
  c.attempt = job_.attempt();
  c.pass_index = job_.pass();
  c.speed_mm_s = e.process.pass_speed_mm_s;
  c.z_mm = e.process.nozzle_gap_mm;
  c.grid = to_message(fires.spec);
  c.lead_mm = b ? 0.0 : lead_mm_;
  if (b) {  // nozzle B is above the cell
    const StagePlace first =
        stage_place(fires.spec, 0, 0, {}, {e.jet_b.offset_x_mm, e.jet_b.offset_y_mm, 0.0}, true);
    c.grid.origin_x_mm = first.x_mm;
    c.grid.origin_y_mm = first.y_mm;
    c.z_mm += e.jet_b.offset_z_mm;
  }
  c.n = std::int32_t(fires.size());
  c.fires.assign(fires.cells.begin(), fires.cells.end());
  const drivers::RasterParams raster{.speed_mm_s = c.speed_mm_s,
                                     .acceleration_mm_s2 = e.stage.acceleration_mm_s2,
                                     .max_rate_hz = jets_rate_hz(e)};
  job_.keep_apart(drivers::quicker_apart_mm(fires, raster, job_.placement()));
  set_placement(c, job_.placement());
  const double row_s = extent_mm(fires.spec.nx, fires.spec.pitch_x_mm) / c.speed_mm_s + 1.0;
  double pass_s = fires.spec.ny * row_s;
  if (!job_.offsets().cells.empty())
    pass_s += drivers::raster_time_s(drivers::plan_raster(fires, 0, raster, job_.placement()), raster);
  stamp(c, NodeId::kStage, pass_s, now, out);
  out.send(channels::kStageCommand, c);
}

void DropletLoop::send_jet(JetVerb verb, Time now, Outbox& out) {
  jet_command_t c{};
  c.verb = std::int8_t(verb);
  c.attempt = job_.attempt();
  c.pass_index = job_.pass();
  c.expected = job_.remaining();
  const bool b = job_.material() == Material::kB;
  stamp(c, b ? NodeId::kJetB : NodeId::kJet, 10.0, now, out);
  out.send(b ? channels::kJetBCommand : channels::kJetCommand, c);
}

void DropletLoop::send_exposure(Time now, Outbox& out) {
  lamp_command_t c{};
  c.verb = std::int8_t(LampVerb::kExpose);
  c.attempt = job_.attempt();
  c.exposure_s = experiment().process.exposure_s;
  c.iris_percent = experiment().process.iris_percent;
  stamp(c, NodeId::kLamp, c.exposure_s + 10.0, now, out);
  out.send(channels::kLampCommand, c);
}

void DropletLoop::publish_metrics(const height_map_t& map, Time now, Outbox& out) {
  layer_metrics_t m = metrics_of(map, now);
  if (map.rows_expected > 0) {
    const HeightMap height = measured_height_of(map);
    m.rms_inside_mm = error_stats(height, target(), inside_).rms_mm;
    m.rms_rim_mm = error_stats(height, target(), rim_).rms_mm;
  }
  m.drops = map.layer > 0 ? job_.fired() : 0;
  m.drops_total = drops_total_;
  m.objective_mm = objective_mm_;
  m.iterations = iterations_;
  // The mean height added per layer gives the number of layers to the target; before the first layer the
  // nominal layer height.
  const ModelConfig& h = experiment().model;
  const double per_layer = map.layer > 0 && m.mean_height_mm > 0 ? m.mean_height_mm / map.layer
                                                                 : h.h1_mm + 4 * h.h2_mm + 4 * h.h3_mm;
  m.layers_expected = std::int32_t(std::min(1e6, std::ceil(m.target_mean_mm / per_layer)));
  out.send(channels::kLayerMetrics, m);
}

}  // namespace firn
