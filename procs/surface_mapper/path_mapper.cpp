#include "procs/surface_mapper/path_mapper.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "config/ice_lab.h"
#include "core/slice/coverage/footprint.h"
#include "firn/enums.h"
#include "firn/height_map_t.hpp"
#include "firn/preview_t.hpp"
#include "lcmtypes/convert.h"
#include "procs/surface_mapper/node.h"

namespace firn {
namespace {}  // namespace

PathMapper::PathMapper(const Experiment& e, const Machine& machine, slice::PrintPaths paths)
    : paths_(e.ice.map_table == "on" ? slice::with_table(std::move(paths)) : std::move(paths)),
      arm_(make_arm(machine)),
      frame_{*arm_,
             laser_tool(machine, e),
             {e.ice.origin_x_mm, e.ice.origin_y_mm},
             e.ice.origin_z_mm,
             e.laser_point.latency_s},
      pitch_mm_(e.ice.pitch_mm) {
  options_.smooth = e.control.smoothing > 0.0;
  options_.samples = e.ice.map_samples;
  options_.reach_mm = e.ice.measure_spacing_mm;
  subscribe(channels::kTrajectory, this);
  subscribe(channels::kLaserSamples, this);
}

void PathMapper::on(const trajectory_t& m, Time, Outbox& out) {
  if (m.kind != std::int8_t(PathKind::kMeasurement)) return;
  motions_[m.path] = from_message(m).trajectory;
  if (complete()) publish(out);
}

void PathMapper::on(const laser_samples_t& m, Time, Outbox& out) {
  if (m.count < 1 || m.index < 0 || m.index >= m.count || m.scan_id < scan_id_ ||
      (m.scan_id == scan_id_ && mapped_))
    return;
  if (m.scan_id > scan_id_) {
    if (!mapped_)
      out.warn("scan " + std::to_string(scan_id_) + " was left unfinished with " +
               std::to_string(scan_.size()) + " paths");
    scan_.clear();
    scan_id_ = m.scan_id;
    mapped_ = false;
  }
  scan_.try_emplace(m.index, m);
  if (complete()) publish(out);
}

bool PathMapper::complete() const {
  if (mapped_ || scan_.empty() || std::int32_t(scan_.size()) < scan_.begin()->second.count) return false;
  return std::all_of(scan_.begin(), scan_.end(),
                     [&](const auto& entry) { return motions_.count(entry.second.path) > 0; });
}

void PathMapper::publish(Outbox& out) {
  mapped_ = true;
  const std::int32_t layer = scan_.begin()->second.layer, attempt = scan_.begin()->second.attempt;
  const slice::LayerPaths* paths = slice::find_layer(paths_, layer);
  if (!paths)
    return out.warn("scan " + std::to_string(scan_id_) + ": the print has no layer " + std::to_string(layer));
  std::vector<surface::SurfacePoint> points;
  double expected = 0.0;
  height_map_t m{};
  try {
    for (const auto& [index, samples] : scan_) {
      const Trajectory& t = motions_.at(samples.path);
      const surface::ReadingCounts n =
          surface::add_readings(t, frame_, samples.period_s, samples.distance_mm, points);
      const double motion_s = t.tick_s * double(t.samples() > 0 ? t.samples() - 1 : 0);
      expected +=
          std::max(double(n.taken), std::max(0.0, (motion_s - frame_.latency_s) / samples.period_s - 1.0));
      m.sample_utime_us = std::max(m.sample_utime_us, samples.sample_utime_us);
    }
  } catch (const std::invalid_argument& e) {
    return out.warn("scan " + std::to_string(scan_id_) + ": " + e.what());
  }
  const GridSpec grid = slice::footprint_grid(*paths, pitch_mm_);
  surface::ScatterEstimate e = surface::estimate_surface(
      grid, slice::footprint_mask(slice::footprint_materials(*paths, grid)), points, options_);
  if (e.covered_fraction == 0.0) std::fill(e.height.cells.begin(), e.height.cells.end(), 0.0);
  m.layer = layer;
  m.attempt = attempt;
  m.map_id = ++maps_;
  m.noise_std_mm = e.noise_std_mm;
  m.measured_fraction = expected > 0.0 ? std::min(1.0, double(points.size()) / expected) : 0.0;
  set_height(m, e.height);
  m.quality.assign(e.quality.cells.begin(), e.quality.cells.end());
  out.send(channels::kHeightMap, std::move(m));
  out.send(channels::kHeightPreview, preview_of(e.height, layer));
  std::erase_if(motions_, [&](const auto& entry) { return entry.first < scan_.begin()->second.path; });
}

}  // namespace firn
