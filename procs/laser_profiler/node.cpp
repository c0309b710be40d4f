#include "procs/laser_profiler/node.h"

#include <algorithm>

#include "config/device_kinds.h"
#include "drivers/laser_profiler/laser_profiler.h"
#include "drivers/laser_profiler/point_scan.h"
#include "drivers/laser_profiler/script_profiler.h"
#include "firn/scan_done_t.hpp"

namespace firn {
namespace {

std::unique_ptr<drivers::ProfilerDriver> profiler_driver(const Experiment& e) {
  drivers::LaserProfilerOptions c{e.laser_profiler};
  c.host_latency_s = host_latency_s(e.run.time_scale);
  if (is_python_driver(e, "laser_profiler"))
    return std::make_unique<drivers::ScriptProfiler>(script_options(e, "laser_profiler", c.host_latency_s), c,
                                                     e.stage.counts_per_mm);
  if (has_point_scan(e))
    return std::make_unique<drivers::PointScan>(
        c, drivers::PointScanPlace{0.5 * (e.grid.x_mm(0) + e.grid.x_mm(e.grid.nx - 1)), e.grid.pitch_x_mm});
  return std::make_unique<drivers::LaserProfiler>(c);
}

}  // namespace

LaserProfilerNode::LaserProfilerNode(const Experiment& e)
    : DriverNode(NodeId::kLaserProfiler, profiler_driver(e)),
      counts_per_mm_(e.stage.counts_per_mm),
      offset_y_mm_(e.laser_profiler.offset_y_mm) {
  subscribe(channels::kProfilerCommand, this);
}

void LaserProfilerNode::on(const profiler_command_t& c, Time now, Outbox& out) {
  using drivers::Effects;
  const ProfilerVerb verb = ProfilerVerb(c.verb);
  perform(c, false, now, out, [&](auto& profiler, std::int64_t now_us, Effects& fx) {
    if (verb == ProfilerVerb::kArm) {
      if (c.first_row == 0) rows_received_ = 0;
      scan_ = c;
      profiler->arm(c.rows, now_us, fx);
    } else {
      profiler->end(now_us, fx);
    }
  });
}

void LaserProfilerNode::on_measured(drivers::ProfileRow& p, Time now, Outbox& out) {
  height_profile_t m{};
  m.n = std::int32_t(p.z_mm.size());
  m.layer = scan_.layer;
  m.attempt = scan_.attempt;
  m.scan_id = scan_.scan_id;
  m.row = scan_.first_row + p.row;
  m.rows = std::max(1, scan_.rows_of_scan);  // one profile for a person is a scan of one
  m.sample_utime_us = now.us;
  m.x0_mm = p.x0_mm + scan_.shift_x_mm;
  m.dx_mm = p.dx_mm;
  m.y_mm =
      p.by_encoder ? p.encoder_count / counts_per_mm_ + offset_y_mm_ : scan_.y0_mm + p.row * scan_.pitch_y_mm;
  m.trigger_count = p.trigger_count;
  m.encoder_count = p.encoder_count;
  m.z_mm = std::move(p.z_mm);
  out.send(channels::kHeightProfile, std::move(m));
}

void LaserProfilerNode::on_measured(drivers::ScanDone& d, Time, Outbox& out) {
  rows_received_ += d.rows_received;
  if (scan_.first_row + d.rows_expected < scan_.rows_of_scan) return;
  scan_done_t m{};
  m.layer = scan_.layer;
  m.attempt = scan_.attempt;
  m.scan_id = scan_.scan_id;
  m.rows_expected = scan_.rows_of_scan;
  m.rows_received = rows_received_;
  out.send(channels::kScanDone, std::move(m));
}

std::unique_ptr<Node> make_laser_profiler(const std::string& config_toml, const Blobs&) {
  return std::make_unique<LaserProfilerNode>(parse_recorded_experiment(config_toml, "experiment.toml"));
}

}  // namespace firn
