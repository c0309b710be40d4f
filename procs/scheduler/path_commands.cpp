// Commands that the path loop sends on entering a phase, and reports of the loop.
#include <algorithm>
#include <cmath>

#include "core/slice/coverage/footprint.h"
#include "firn/heater_command_t.hpp"
#include "firn/laser_command_t.hpp"
#include "firn/layer_metrics_t.hpp"
#include "firn/robot_command_t.hpp"
#include "firn/valve_command_t.hpp"
#include "lcmtypes/convert.h"
#include "procs/scheduler/path_loop.h"

namespace firn {
namespace {

constexpr double kUpload_s = 30.0;  // the longest path at 115200 baud takes 24 s
constexpr double kWarmUp_s = 3600.0;
constexpr double kCollect_s = 20.0;  // 13107 values at 115200 baud take 10 s

std::int32_t sample_at(double s, double tick_s) { return std::int32_t(std::lround(s / tick_s)); }

}  // namespace

void PathLoop::proceed(Phase next, Time now, Outbox& out) {
  count_phase_time(now);
  phase_ = next;
  const double scale = experiment().run.time_scale;
  const PathTask* deposit = depositing() ? &task() : nullptr;
  const PathTask* scan = scan_at_ < scan_.size() ? &scan_[scan_at_] : nullptr;
  const bool between_paths = next == Phase::kLoadScan || (next == Phase::kLoadPath && list_ + attempt_ == 0);
  if (between_paths && holds(place(), out)) return;
  switch (next) {
    case Phase::kHeat:
      return send_heater(now, out);
    case Phase::kWarmUp:
      out.wake_at(kDeadline, now.after_s(kWarmUp_s));
      return act_on_temperature(now, out);
    case Phase::kHoming:
      return send_robot(RobotVerb::kHome, nullptr, 0, 0, 60.0, now, out);
    case Phase::kAwaitPaths:
      out.wake_at(kDeadline,
                  now.after_s((2.0 * info(NodeId::kPathPlanner).longest_step_s + kSlackWall_s) * scale));
      return act_on_batch(now, out);
    case Phase::kLoadPath:
      return send_robot(RobotVerb::kLoad, deposit, list_, 0, kUpload_s, now, out);
    case Phase::kLoadPulses:
      return send_valve(ValveVerb::kLoad, now, out);
    case Phase::kArmValve:
      return send_valve(ValveVerb::kArm, now, out);
    case Phase::kRunPath: {
      untouched_ = false;
      begun_ = list_ == 0 ? now : begun_;
      const int signal = ValveId(deposit->job.valve) == ValveId::kB ? kSignalValveB : kSignalValveA;
      return send_robot(RobotVerb::kRun, deposit, list_, signal, deposit->job.duration_s + kUpload_s, now,
                        out);
    }
    case Phase::kDisarmValve:
      if (late_count_) return settle_list(answer_t(*late_count_), now, out);
      return send_valve(ValveVerb::kDisarm, now, out);
    case Phase::kAwaitOperator:
      if (!waits_for_operator())
        return next_path(now, out);  // the operator's word has come before the arm was home
      return out.wake_at(kOperator, now.after_s(2.0 * scale));
    case Phase::kRaise:
      return send_robot(RobotVerb::kHome, nullptr, 0, 0, 60.0, now, out);
    case Phase::kLoadScan:
      if (scan_at_ == 0) {
        ++scan_id_;
        map_.reset();  // of a scan that was cut off
        surface_.reset();
      }
      return send_robot(RobotVerb::kLoad, scan, 0, 0, kUpload_s, now, out);
    case Phase::kArmLaser:
      return send_laser(LaserVerb::kArm, now, out);
    case Phase::kRunScan:
      return send_robot(RobotVerb::kRun, scan, 0, kSignalLaser, scan->job.duration_s + kUpload_s, now, out);
    case Phase::kCollect:
      return send_laser(LaserVerb::kCollect, now, out);
    case Phase::kAwaitMap:
      out.wake_at(kDeadline,
                  now.after_s((info(NodeId::kSurfaceMapper).longest_step_s + kSlackWall_s) * scale));
      return act_on_map(now, out);
    case Phase::kAwaitSurface:
      out.wake_at(kDeadline, now.after_s(info(NodeId::kController).longest_step_s * 2.0 * scale));
      return act_on_surface(now, out);
    default:
      return;
  }
}

void PathLoop::send_robot(RobotVerb verb, const PathTask* task, int list, int signals, double allowed_s,
                          Time now, Outbox& out) {
  robot_command_t c{};
  c.verb = std::int8_t(verb);
  if (task) {
    c.path = task->job.path;
    c.attempt = attempt_;
    if (task->job.lists > 1) {
      c.from_sample = sample_at(task->list_start_s[std::size_t(list)], tick_s_);
      c.to_sample =
          list + 1 < task->job.lists ? sample_at(task->list_start_s[std::size_t(list) + 1], tick_s_) : 0;
    }
  }
  c.signals = signals;
  stamp(c, NodeId::kRobot, allowed_s, now, out);
  out.send(channels::kRobotCommand, c);
}

void PathLoop::send_valve(ValveVerb verb, Time now, Outbox& out) {
  valve_command_t c{};
  c.verb = std::int8_t(verb);
  c.attempt = attempt_;
  c.path = task().job.path;
  c.list = list_;
  c.expected = task().list_pulses.empty() ? 0 : task().list_pulses[std::size_t(list_)];
  const bool b = ValveId(task().job.valve) == ValveId::kB;
  stamp(c, b ? NodeId::kValveB : NodeId::kValveA, kUpload_s, now, out);
  out.send(b ? channels::kValveBCommand : channels::kValveACommand, c);
}

void PathLoop::send_laser(LaserVerb verb, Time now, Outbox& out) {
  const path_job_t& job = scan_[scan_at_].job;
  laser_command_t c{};
  c.verb = std::int8_t(verb);
  c.attempt = scan_attempt_;
  c.scan_id = scan_id_;
  c.path = job.path;
  c.index = std::int32_t(scan_at_);
  c.count = std::int32_t(scan_.size());
  c.material = job.material;
  c.period_s = 1.0 / experiment().laser_point.rate_hz;
  c.samples = std::int32_t(std::clamp(std::ceil(job.duration_s / c.period_s), 1.0, 65536.0));
  stamp(c, NodeId::kLaserPoint, kCollect_s, now, out);
  out.send(channels::kLaserCommand, c);
}

void PathLoop::send_heater(Time now, Outbox& out) {
  heater_command_t c{};
  c.verb = std::int8_t(HeaterVerb::kSet);
  c.set_degC[0] = experiment().heater.tip_degC;
  c.set_degC[1] = experiment().heater.window_degC;
  c.set_degC[2] = experiment().heater.conduit_degC;
  stamp(c, NodeId::kHeater, 10.0, now, out);
  out.send(channels::kHeaterCommand, c);
}

void PathLoop::publish_metrics(const height_map_t& map, Outbox& out) {
  layer_metrics_t m{};
  m.layer = map.layer;
  m.attempt = map.attempt;
  m.map_id = map.map_id;
  if (const slice::LayerPaths* layer = slice::find_layer(paths_, map.layer)) {
    const Mask mask = slice::footprint_mask(slice::footprint_materials(*layer, newest_.spec));
    const double nominal_mm = map.layer * experiment().ice.layer_height_mm;
    const ErrorStats e = error_stats(newest_, HeightMap(newest_.spec, nominal_mm), mask);
    m.target_mean_mm = nominal_mm;
    m.mean_height_mm = nominal_mm + e.mean_mm;
    m.mean_error_mm = e.mean_mm;
    m.rms_mm = e.rms_mm;
    m.std_mm = e.std_mm;
    m.min_error_mm = e.min_mm;
    m.max_error_mm = e.max_mm;
    m.volume_mm3 = m.mean_height_mm * double(e.cells) * newest_.spec.pitch_x_mm * newest_.spec.pitch_y_mm;
  }
  m.drops = pulses_interval_;
  m.drops_total = pulses_total_;
  m.deposit_s = deposit_s_;
  m.scan_s = scan_s_;
  m.decide_s = decide_s_;
  m.layers_expected = paths_.layers.empty() ? 0 : paths_.layers.back().layer;
  out.send(channels::kLayerMetrics, m);
}

}  // namespace firn
