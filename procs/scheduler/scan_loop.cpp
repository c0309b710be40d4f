#include "procs/scheduler/scan_loop.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "config/swaths.h"
#include "lcmtypes/convert.h"

namespace firn {

ScanLoop::ScanLoop(const Experiment& experiment, Phase act, HeightMap target, Mask mask)
    : Scheduler(experiment, act),
      mask_(std::move(mask)),
      target_(std::move(target)),
      swaths_mm_(swath_shifts_mm(experiment)) {
  subscribe(channels::kHeightMap, this);
}

// A map can overtake the profiler's last answer, or arrive while the lab gets ready again: it is kept until
// its turn.
void ScanLoop::on(const height_map_t& m, Time now, Outbox& out) {
  if (m.layer != layers_done_ || m.attempt != scan_attempt_ || m.map_id == map_id_) return;
  map_ = m;
  if (phase_ == Phase::kAwaitMap) act_on_map(now, out);
}

void ScanLoop::operator_accepted(Time now, Outbox& out) {
  if (phase_ == Phase::kAwaitPlan) act_on_plan(now, out);
}

std::string ScanLoop::awaited() const {
  if (phase_ == Phase::kAwaitMap) return "no height map for scan " + std::to_string(scan_id_);
  return "no plan for map " + std::to_string(map_id_);
}

void ScanLoop::scan_again(Time now, Outbox& out) {
  ++scan_attempt_;
  swath_ = 0;
  proceed(Phase::kArmProfiler, now, out);
}

bool ScanLoop::enter_scan(Phase next, Time now, Outbox& out) {
  switch (next) {
    case Phase::kHoming:
      send_home(now, out);
      return true;
    case Phase::kArmProfiler:
      map_.reset();  // of a scan that a crash cut off: its map and plan may have arrived all the same
      forget_plan();
      send_profiler(ProfilerVerb::kArm, now, out);
      return true;
    case Phase::kScan:
      send_scan(now, out);
      return true;
    case Phase::kEndScan:
      send_profiler(ProfilerVerb::kEnd, now, out);
      return true;
    case Phase::kAwaitMap:
      swath_ = 0;
      out.wake_at(kDeadline, now.after_s(kSlackWall_s * experiment().run.time_scale));
      act_on_map(now, out);
      return true;
    case Phase::kAwaitPlan:
      out.wake_at(kDeadline,
                  now.after_s(info(NodeId::kController).longest_step_s * 2.0 * experiment().run.time_scale));
      if (waits_for_operator()) out.wake_at(kOperator, now.after_s(2.0 * experiment().run.time_scale));
      act_on_plan(now, out);
      return true;
    default:
      return false;
  }
}

bool ScanLoop::scan_answered(Time now, Outbox& out) {
  switch (phase_) {
    case Phase::kHoming:
      proceed(Phase::kArmProfiler, now, out);
      return true;
    case Phase::kArmProfiler:
      proceed(Phase::kScan, now, out);
      return true;
    case Phase::kScan:
      proceed(Phase::kEndScan, now, out);
      return true;
    case Phase::kEndScan:
      proceed(++swath_ < swaths_mm_.size() ? Phase::kArmProfiler : Phase::kAwaitMap, now, out);
      return true;
    default:
      return false;
  }
}

void ScanLoop::send_home(Time now, Outbox& out) {
  stage_command_t c{};
  c.verb = std::int8_t(StageVerb::kHome);
  stamp(c, NodeId::kStage, 30.0, now, out);
  out.send(channels::kStageCommand, c);
}

void ScanLoop::send_move(double x_mm, double y_mm, Time now, Outbox& out) {
  stage_command_t c{};
  c.verb = std::int8_t(StageVerb::kMove);
  c.x_mm = x_mm;
  c.y_mm = y_mm;
  c.z_mm = experiment().process.nozzle_gap_mm;
  c.speed_mm_s = experiment().process.pass_speed_mm_s;
  stamp(c, NodeId::kStage, 10.0, now, out);
  out.send(channels::kStageCommand, c);
}

void ScanLoop::send_scan(Time now, Outbox& out) {
  stage_command_t c = scan_command(experiment(), swath(), scan_speed_mm_s());
  stamp(c, NodeId::kStage, scan_time_s(experiment(), c.speed_mm_s), now, out);
  out.send(channels::kStageCommand, c);
}

void ScanLoop::send_profiler(ProfilerVerb verb, Time now, Outbox& out) {
  if (verb == ProfilerVerb::kArm && swath_ == 0) ++scan_id_;
  profiler_command_t c = profiler_command(experiment(), swath(), verb);
  stamp(c, NodeId::kLaserProfiler, 10.0, now, out);
  out.send(channels::kProfilerCommand, c);
}

layer_metrics_t ScanLoop::metrics_of(const height_map_t& map, Time now) {
  const HeightMap height = measured_height_of(map);
  const ErrorStats e = error_stats(height, target_, mask_);
  double target_sum = 0.0, height_sum = 0.0;
  for (std::size_t c = 0; c < height.size(); ++c) {
    if (!mask_.cells[c] || !std::isfinite(height.cells[c])) continue;
    target_sum += target_.cells[c];
    height_sum += height.cells[c];
  }
  const double n = double(std::max<std::int64_t>(1, e.cells));
  layer_metrics_t m = times_of_layer(now);
  m.layer = map.layer;
  m.attempt = map.attempt;
  m.map_id = map.map_id;
  m.target_mean_mm = target_sum / n;
  m.mean_height_mm = height_sum / n;
  m.mean_error_mm = e.mean_mm;
  m.rms_mm = e.rms_mm;
  m.std_mm = e.std_mm;
  m.min_error_mm = e.min_mm;
  m.max_error_mm = e.max_mm;
  m.volume_mm3 = height_sum * experiment().grid.pitch_x_mm * experiment().grid.pitch_y_mm;
  if (map.rows_expected > 0) {
    m.rows_lost = rows_lost_;
    m.cells_guessed = e.missing;
    m.volume_mm3 *= double(e.cells + e.missing) / n;
  }
  rows_lost_ = 0;
  return m;
}

layer_metrics_t ScanLoop::times_of_layer(Time now) {
  count_phase_time(now);
  layer_metrics_t m{};
  m.deposit_s = std::exchange(deposit_s_, 0.0);
  m.cure_s = std::exchange(cure_s_, 0.0);
  m.scan_s = std::exchange(scan_s_, 0.0);
  m.decide_s = std::exchange(decide_s_, 0.0);
  return m;
}

}  // namespace firn
