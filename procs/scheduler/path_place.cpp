// The place and the height of the first maps of a path printer, against the calibrated uncertainty.
#include <cmath>

#include "core/grid/cell_quality.h"
#include "core/slice/coverage/footprint.h"
#include "lcmtypes/convert.h"
#include "procs/scheduler/path_loop.h"
#include "procs/scheduler/sensor_check.h"

namespace firn {
namespace {

constexpr double kFlowShare = 0.1;  // of the first interval's height: the uncertainty of a calibrated valve

HeightMap on_readings(const height_map_t& m) {
  HeightMap h = height_of(m);
  for (std::size_t c = 0; c < h.size() && c < m.quality.size(); ++c)
    if (CellQuality(m.quality[c]) == CellQuality::kGuessed) h.cells[c] = kNotMeasured;
  return h;
}

}  // namespace

// The laser is aside of the outline of both materials, a nozzle of its own material's.
std::string PathLoop::misplaced(const HeightMap& rise, int layer) const {
  const slice::LayerPaths* top = slice::find_layer(paths_, layer);
  if (!top) return "";
  const double limit_mm = experiment().laser_point.offset_limit_mm;
  const auto material = slice::footprint_materials(*top, rise.spec);
  const auto [laid, other] = [&] {
    std::pair<Mask, Mask> of{Mask(rise.spec), Mask(rise.spec)};  // part, scaffold
    for (std::size_t c = 0; c < rise.size(); ++c) {
      of.first.cells[c] = material.cells[c] == 1;
      of.second.cells[c] = material.cells[c] > 1;
    }
    return of;
  }();
  for (const bool scaffold : {false, true}) {
    const Mask &own = scaffold ? other : laid, &beside = scaffold ? laid : other;
    if (own.count() == 0 || beside.count() == 0) break;  // of one material: by its edges
    const std::string text = check_outline(
        rise, own, beside, limit_mm,
        {scaffold ? "the first interval's scaffold" : "the first interval's part",
         std::string("tool_") + (scaffold ? "scaffold" : "water") + " of the machine is not as calibrated",
         std::string("measure the nozzle of ") + (scaffold ? "valve_b" : "valve_a") +
             ", or run firn calibrate laser-offset"});
    if (!text.empty()) return text;
  }
  HeightMap on_part = rise;
  for (std::size_t c = 0; c < on_part.size(); ++c)
    if (!material.cells[c]) on_part.cells[c] = kNotMeasured;
  return check_edges(
      on_part, limit_mm,
      {"the first interval",
       "laser_point.offset_x_mm, laser_point.offset_y_mm or a tool of the machine is not as calibrated",
       "run firn calibrate laser-offset, then print again; if it stays, the nozzle is aside"});
}

bool PathLoop::doubted(const height_map_t& m, Time now, Outbox& out) {
  const LaserPointConfig& laser = experiment().laser_point;
  if (mapped_layers_ > 0 || in_doubt_ || (laser.bias_limit_mm == 0.0 && laser.offset_limit_mm == 0.0))
    return false;
  HeightMap height = on_readings(m);
  std::string doubt;
  if (m.layer == 0) {
    doubt = check_bare(height, laser.bias_limit_mm,
                       {"the bare table", "laser_point.offset_z_mm or ice.origin_z_mm is not as calibrated",
                        "run firn calibrate laser-offset"});
  } else {
    if (newest_.size() != 0) {
      const HeightMap table = resample(newest_, height.spec, kNotMeasured);
      for (std::size_t c = 0; c < height.size(); ++c) height.cells[c] -= table.cells[c];
    }
    doubt = misplaced(height, m.layer);
    const double laid_mm = m.layer * experiment().ice.layer_height_mm;
    if (doubt.empty() && !table_first_ && laser.bias_limit_mm > 0.0) {
      HeightMap off = height;
      for (double& h : off.cells) h -= laid_mm;
      const std::string text =
          check_bare(off, laser.bias_limit_mm + kFlowShare * laid_mm,
                     {"the first interval, less its nominal height,", "the laser's height or a valve's flow",
                      "ice.map_table = \"on\" tells which: it measures the bare table first"});
      if (!text.empty()) send_fault(Severity::kWarning, 15, text, out);
    }
  }
  return stopped_by_doubt(doubt, scan_attempt_, Phase::kLoadScan, now, out);
}

void PathLoop::scan_again(Time now, Outbox& out) {
  count_phase_time(now);
  measure_again(now, out);
}

}  // namespace firn
