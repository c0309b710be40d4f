#include "procs/scheduler/line_loop.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>

#include "config/aerosol_lab.h"
#include "firn/camera_command_t.hpp"
#include "firn/path_report_t.hpp"
#include "lcmtypes/convert.h"

namespace firn {
namespace {

constexpr double kPicture_s = 1.0;  // longest time of one picture
constexpr double kStandsOut = 8.0;  // standard deviations of a cell

// A run past an end is nearer.
Mask away_from(const HeightMap& target, double clear_mm) {
  const GridSpec& g = target.spec;
  const int wide = int(clear_mm / g.pitch_x_mm), high = int(clear_mm / g.pitch_y_mm);
  Mask rows(g), beside(g);
  for (int j = 0; j < g.ny; ++j)
    for (int i = 0; i < g.nx; ++i)
      for (int n = std::max(0, i - wide); n <= std::min(g.nx - 1, i + wide); ++n)
        rows.at(i, j) |= target.at(n, j) > 0.0;
  for (int j = 0; j < g.ny; ++j)
    for (int i = 0; i < g.nx; ++i) {
      bool near = false;
      for (int n = std::max(0, j - high); n <= std::min(g.ny - 1, j + high); ++n) near |= rows.at(i, n) != 0;
      beside.at(i, j) = !near;
    }
  return beside;
}

std::vector<Point2> points_of(const std::optional<followed_path_t>& followed) {
  std::vector<Point2> points;
  if (followed)
    for (std::size_t k = 0; k < followed->x_mm.size(); ++k)
      points.push_back({double(followed->x_mm[k]), double(followed->y_mm[k])});
  return points;
}

}  // namespace

LineLoop::LineLoop(const Experiment& experiment, HeightMap target, Mask mask, const PrintJob& job)
    : ScanLoop(experiment, Phase::kRunPath, std::move(target), std::move(mask)),
      beside_(away_from(this->target(), experiment.process.beside_mm)),
      stations_(line_stations(job, experiment.aerosol.station_mm)),
      has_profiler_(has_profiler(experiment)) {
  subscribe(channels::kLinePlan, this);
  if (path_recorded()) subscribe(channels::kFollowedPath, this);
  if (heats()) subscribe(channels::kTemperature, this);
  if (!firn::on(experiment.camera.use)) return;
  for (const LineStation& s : stations_) places_.push_back(s.at);
  if (has_profiler_) return;
  for (const LineEnd& end : line_ends(job, 0.0)) places_.push_back(end.at);
}

std::string LineLoop::doubt() const {
  return "lines of layer " + std::to_string(layers_done_) +
         " are in doubt and the open loop cannot correct them: look at the part, then resume with "
         "--accept-doubt";
}

void LineLoop::supplied(Time now, Outbox& out) {
  switch (after_supply_) {
    case Phase::kArmProfiler:
    case Phase::kScan:
    case Phase::kEndScan:
    case Phase::kGasOff:
      return scan_again(now, out);
    case Phase::kPictures:
      return proceed(Phase::kToCamera, now, out);
    case Phase::kAwaitPlan:
      if (!has_profiler_ && !plan_) return scan_again(now, out);  // a picture may be lost
      return proceed(Phase::kAwaitPlan, now, out);
    case Phase::kRunPath:
      // Nothing of it was begun: the same way is safe.
      if (!act_answer_ || Outcome(act_answer_->outcome) == Outcome::kNone) {
        act_answer_.reset();
        return proceed(Phase::kRunPath, now, out);
      }
      settle(errors_of_way(), out);
      return proceed(Phase::kArmProfiler, now, out);
    default:
      return proceed(after_supply_, now, out);
  }
}

void LineLoop::proceed(Phase next, Time now, Outbox& out) {
  count_phase_time(now);
  if (next == Phase::kArmProfiler && has_profiler_ && look_due()) next = Phase::kToCamera;
  phase_ = next;
  if (next == Phase::kArmProfiler && holds("before the scan of layer " + std::to_string(layers_done_), out))
    return;
  if (next == Phase::kArmProfiler && !has_profiler_) {
    forget_plan();  // of a walk that was cut off
    look_ = 0;
    phase_ = next = Phase::kToCamera;
  }
  if (enter_supply(next, now, out) || enter_scan(next, now, out)) return;
  if (next == Phase::kToCamera) send_to_place(now, out);
  if (next == Phase::kPictures) send_picture(now, out);
  if (next == Phase::kRunPath) send_way(now, out);
}

void LineLoop::answered(const answer_t&, Time now, Outbox& out) {
  if (phase_ == Phase::kToCamera) return proceed(Phase::kPictures, now, out);
  if (phase_ == Phase::kPictures) {
    if (++look_ < places_.size()) return proceed(Phase::kToCamera, now, out);
    look_ = 0;
    looked_layer_ = layers_done_;
    return proceed(has_profiler_ ? Phase::kArmProfiler : Phase::kAwaitPlan, now, out);
  }
  if (supply_answered(now, out) || scan_answered(now, out) || phase_ != Phase::kRunPath) return;
  path_over(now, out);
}

bool LineLoop::rejected(const height_map_t& m, Time now, Outbox& out) {
  const double needed = experiment().process.min_measured_fraction;
  const int lost = m.rows_expected - m.rows_received;
  rows_lost_ += lost;
  const bool little = m.measured_fraction < needed;
  if (!little && !(lost > experiment().process.max_lost_rows_share * m.rows_expected)) return false;
  const std::string what = "the scan of layer " + std::to_string(m.layer) + " measures " +
                           std::to_string(m.measured_fraction) + " of the grid, " + std::to_string(needed) +
                           " is needed, and lost " + std::to_string(lost) + " rows";
  const Figure figure = little
                            ? Figure{m.measured_fraction, needed, "", "process.min_measured_fraction"}
                            : Figure{double(lost) / m.rows_expected, experiment().process.max_lost_rows_share,
                                     "", "process.max_lost_rows_share"};
  if (scan_attempt_ < experiment().process.max_rescans) {
    out.report(Severity::kWarning, what + "; measuring again", 13, figure);
    scan_again(now, out);
    return true;
  }
  phase_ = Phase::kArmProfiler;  // a resume continues here
  fail(13, what, now, out, figure);
  return true;
}

void LineLoop::act_on_map(Time now, Outbox& out) {
  if (!map_) return;
  const height_map_t m = *std::exchange(map_, std::nullopt);
  out.cancel(kDeadline);
  if (from_message(m.grid) != experiment().grid)
    return fail(0, "HEIGHT_MAP: grid is not the experiment's", now, out);
  if (rejected(m, now, out)) return;
  map_id_ = m.map_id;
  newest_ = measured_height_of(m);
  noise_mm_ = m.noise_std_mm;
  publish_metrics(metrics_of(m, now), out);
  proceed(Phase::kAwaitPlan, now, out);
}

void LineLoop::on(const line_plan_t& m, Time now, Outbox& out) {
  if (m.attempt != scan_attempt_ || m.layer != layers_done_ + 1) return;
  plan_ = m;
  if (phase_ == Phase::kAwaitPlan) act_on_plan(now, out);
}

double LineLoop::ink_beside_mm3() const {
  if (before_.size() != newest_.size()) return 0.0;
  double sum = 0.0;
  for (std::size_t c = 0; c < newest_.size(); ++c) {
    const double rise = newest_.cells[c] - before_.cells[c];
    if (beside_.cells[c] && rise > kStandsOut * noise_mm_) sum += rise;
  }
  return sum * newest_.spec.pitch_x_mm * newest_.spec.pitch_y_mm;
}

bool LineLoop::stopped_by_pictures(const line_plan_t& m, Time now, Outbox& out) {
  if (!way_done_ || layers_done_ == 0) return false;
  const auto unseen = std::ranges::count_if(m.seen_width_mm, [](float w) { return std::isnan(w); });
  const double seen = m.looks > 0 ? 1.0 - double(unseen) / double(m.looks) : 0.0;
  const bool open = PlanDecision(m.decision) == PlanDecision::kStop;
  if (seen >= experiment().process.least_rise_share && !open) return false;
  way_done_ = false;  // after the stop somebody has been at the nozzle
  phase_ = Phase::kArmProfiler;
  fail(12,
       open ? m.reason
            : "the camera sees lines at " + std::to_string(seen) + " of the stations after layer " +
                  std::to_string(layers_done_) + ": the shutter stays closed or the nozzle is clogged",
       now, out,
       open ? Figure() : Figure{seen, experiment().process.least_rise_share, "", "process.least_rise_share"});
  return true;
}

bool LineLoop::stopped_by_rise(const line_plan_t& m, Time now, Outbox& out) {
  if (!has_profiler_) return stopped_by_pictures(m, now, out);
  if (!way_done_ || layers_done_ == 0 || m.layer_area_mm2.size() != way_.speed_mm_s.size()) return false;
  double measured = 0.0, planned = 0.0;
  for (std::size_t s = 0; s < m.layer_area_mm2.size(); ++s) {
    if (std::isnan(m.layer_area_mm2[s]) || !(way_.speed_mm_s[s] > 0.0f)) continue;
    measured += double(m.layer_area_mm2[s]);
    planned += experiment().aerosol.flow_mm3_s * experiment().aerosol.solids * way_.flow_share /
               double(way_.speed_mm_s[s]);
  }
  if (!(planned > 0.0)) return false;
  const double share = measured / planned;
  const ProcessConfig& p = experiment().process;
  const double beside =
      ink_beside_mm3() / (experiment().aerosol.flow_mm3_s * experiment().aerosol.solids * way_.open_s);
  if (share >= p.least_rise_share && share <= p.most_rise_share && !(beside > p.most_beside_share))
    return false;
  const std::string what = "the lines of layer " + std::to_string(layers_done_) + " hold " +
                           std::to_string(share) + " of the ink that was planned, " + std::to_string(beside) +
                           " lies away from them: " +
                           (beside > p.most_beside_share ? "the shutter stays open"
                            : share < p.least_rise_share ? "the shutter stays closed or the nozzle is clogged"
                                                         : "the flow is wrong");
  way_done_ = false;  // after the stop somebody has been at the nozzle
  phase_ = Phase::kArmProfiler;
  const Figure figure =
      beside > p.most_beside_share ? Figure{beside, p.most_beside_share, "", "process.most_beside_share"}
      : share < p.least_rise_share ? Figure{share, p.least_rise_share, "", "process.least_rise_share"}
                                   : Figure{share, p.most_rise_share, "", "process.most_rise_share"};
  fail(12, what, now, out, figure);
  return true;
}

void LineLoop::act_on_plan(Time now, Outbox& out) {
  if (!plan_ || plan_->map_id != map_id_ || waits_for_operator()) return;
  const line_plan_t m = *plan_;
  out.cancel(kDeadline);
  if (!has_profiler_) {  // its heights are not told
    layer_metrics_t metrics = times_of_layer(now);
    metrics.layer = layers_done_;
    metrics.attempt = scan_attempt_;
    publish_metrics(metrics, out);
  }
  if (stopped_by_rise(m, now, out)) return;
  if (PlanDecision(m.decision) == PlanDecision::kEnd) return proceed(Phase::kGasOff, now, out);
  if (PlanDecision(m.decision) == PlanDecision::kStop) {
    phase_ = Phase::kArmProfiler;
    return finish_run(RunOutcome::kWaitsForOperator, 3, m.reason, out);
  }
  if (ended_by_operator(Phase::kArmProfiler, out)) return;
  plan_.reset();
  in_doubt_ = false;
  way_ = m;
  followed_.reset();
  if (std::exchange(sheath_share_, m.sheath_share) != m.sheath_share) gas_since_.reset();
  after_supply_ = Phase::kRunPath;
  proceed(Phase::kGas, now, out);
}

bool LineLoop::waits_for_operator() const {
  return in_doubt_ && experiment().control.scheme == "open_loop" && !doubt_accepted_;
}

void LineLoop::send_way(Time now, Outbox& out) {
  way_began_us_ = now.us;
  before_ = newest_;
  stage_command_t c{};
  c.verb = std::int8_t(StageVerb::kTrace);
  c.attempt = way_.attempt;
  c.scan_id = way_.path;
  c.z_mm = experiment().process.nozzle_gap_mm;
  constexpr double kUpload_s = 30.0;  // of thousands of numbers, one by one
  stamp(c, NodeId::kStage, way_.duration_s + kUpload_s, now, out);
  out.send(channels::kStageCommand, c);
}

bool LineLoop::look_due() const { return !places_.empty() && looked_layer_ != layers_done_; }

void LineLoop::send_to_place(Time now, Outbox& out) {
  const Point2& p = places_[look_];
  send_move(p.x_mm - experiment().aerosol.camera_x_mm, p.y_mm - experiment().aerosol.camera_y_mm, now, out);
}

void LineLoop::send_picture(Time now, Outbox& out) {
  camera_command_t c{};
  c.verb = std::int8_t(CameraVerb::kSweep);
  c.attempt = scan_attempt_;
  c.sweep_id = std::int64_t(look_) + 1;
  c.frames = 1;
  c.gain_db = experiment().camera.gain_db;
  stamp(c, NodeId::kCamera, kPicture_s + experiment().camera.exposure_us * 1e-6, now, out);
  out.send(channels::kCameraCommand, c);
}

void LineLoop::publish_metrics(layer_metrics_t m, Outbox& out) {
  m.drops = m.layer > 0 ? way_.switches : 0;
  m.drops_total = switches_total_;
  m.layers_expected = experiment().aerosol.layers;
  out.send(channels::kLayerMetrics, m);
}

bool LineLoop::path_recorded() const { return experiment().stage.path_sample_s > 0.0; }

// It can overtake the answer, or arrive after a stop has ended the phase.
void LineLoop::on(const followed_path_t& m, Time now, Outbox& out) {
  if (m.path != way_.path) return;
  followed_ = m;
  if (phase_ == Phase::kRunPath && act_answer_) path_over(now, out);
}

void LineLoop::path_over(Time now, Outbox& out) {
  if (path_recorded() && !followed_)
    return out.wake_at(kDeadline, now.after_s(kSlackWall_s * experiment().run.time_scale));
  if (path_recorded()) out.cancel(kDeadline);
  const PathErrors errors = errors_of_way();
  const Violation off = off_path(errors);
  settle(errors, out);
  if (off.empty()) return proceed(Phase::kArmProfiler, now, out);
  phase_ = Phase::kArmProfiler;  // a resume measures what lies there
  fail(17, off.text, now, out, off.figure);
}

PathErrors LineLoop::errors_of_way() const {
  const std::vector<Point2> followed = points_of(followed_);
  if (followed.empty() || way_.t_s.empty()) return {};
  std::vector<PathKnot> knots;
  for (std::size_t k = 0; k < way_.t_s.size(); ++k)
    knots.push_back({way_.t_s[k], way_.x_mm[k], way_.y_mm[k], way_.vx_mm_s[k], way_.vy_mm_s[k]});
  return path_errors(TimedPath(std::move(knots)), followed_->period_s, followed, way_.switch_mm);
}

Violation LineLoop::off_path(const PathErrors& e) const {
  const double most = experiment().process.most_path_error_mm;
  const auto by = [most](const char* text, double error_mm) {
    return Violation{text, {error_mm, most, "mm", "process.most_path_error_mm"}};
  };
  char text[240];
  if (e.contour_max_mm > most) {
    std::snprintf(
        text, sizeof text,
        "layer %d: the stage was %.3f mm off its path at (%.3f, %.3f) mm, %.2f s after the beginning; "
        "process.most_path_error_mm is %g",
        way_.layer, e.contour_max_mm, e.worst.x_mm, e.worst.y_mm, e.worst_s, most);
    return by(text, e.contour_max_mm);
  }
  if (e.stall_max_mm > most) {
    std::snprintf(
        text, sizeof text,
        "layer %d: the stage was %.3f mm from its place %.2f s after the beginning of its path: an axis "
        "drags or stands; process.most_path_error_mm is %g",
        way_.layer, e.stall_max_mm, e.stall_s, most);
    return by(text, e.stall_max_mm);
  }
  if (e.switch_max_mm > most) {
    std::snprintf(text, sizeof text,
                  "layer %d: switch %d of the shutter came %.3f mm from its place along the path; "
                  "process.most_path_error_mm is %g",
                  way_.layer, e.worst_switch + 1, e.switch_max_mm, most);
    return by(text, e.switch_max_mm);
  }
  return {};
}

// The layer counts as printed, whole or not: the way is not followed again.
void LineLoop::settle(const PathErrors& errors, Outbox& out) {
  if (!act_answer_) return;
  const answer_t a = *std::exchange(act_answer_, std::nullopt);
  const bool off = !off_path(errors).empty();
  way_done_ = Outcome(a.outcome) == Outcome::kDone && !off;
  if (!way_done_) {
    in_doubt_ = true;
    doubt_accepted_ = false;
  }
  ++layers_done_;
  scan_attempt_ = 0;
  path_report_t r{};
  r.path = r.batch = way_.path;
  r.layer = layers_done_;
  r.attempt = way_.attempt;
  r.outcome = off ? std::int8_t(Outcome::kUnknown) : a.outcome;
  r.pulses_commanded = way_.switches;
  r.pulses_counted = a.counted;
  r.planned_s = way_.duration_s;
  r.measured_s = std::numeric_limits<double>::quiet_NaN();
  r.begin_utime_us = way_began_us_;
  r.volume_mm3 = experiment().aerosol.flow_mm3_s * way_.open_s;
  r.samples = std::int32_t(errors.samples);
  r.contour_max_mm = errors.contour_max_mm;
  r.contour_rms_mm = errors.contour_rms_mm;
  r.following_max_mm = errors.following_max_mm;
  r.lag_max_s = errors.lag_max_s;
  r.switch_max_mm = errors.switch_max_mm;
  r.offset_rms_mm = station_offset_rms_mm(points_of(followed_), stations_);
  switches_total_ += std::max<std::int64_t>(0, a.counted);
  out.send(channels::kPathReport, r);
  followed_.reset();
}

}  // namespace firn
