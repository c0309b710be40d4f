#include "procs/scheduler/path_map_check.h"

#include <cmath>
#include <string>
#include <utility>

#include "core/grid/cell_quality.h"
#include "core/slice/coverage/footprint.h"
#include "lcmtypes/convert.h"
#include "procs/scheduler/sensor_check.h"

namespace firn {
namespace {

constexpr int kFewOfInk = 10;  // of one material: too few for an estimate
constexpr const char* kBiasKey = "laser_point.bias_limit_mm";
constexpr const char* kOffsetKey = "laser_point.offset_limit_mm";
constexpr double kFlowShare = 0.1;  // of the first interval's height: the uncertainty of a calibrated valve

HeightMap on_readings(const height_map_t& m) {
  HeightMap h = height_of(m);
  for (std::size_t c = 0; c < h.size() && c < m.quality.size(); ++c)
    if (CellQuality(m.quality[c]) == CellQuality::kGuessed) h.cells[c] = kNotMeasured;
  return h;
}

// The laser is aside of the outline of both materials, a nozzle of its own material's.
Violation misplaced_material(const Experiment& e, const slice::PrintPaths& paths, int layer,
                             const HeightMap& rise) {
  const slice::LayerPaths* top = slice::find_layer(paths, layer);
  if (!top) return {};
  const double limit_mm = e.laser_point.offset_limit_mm;
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
    Violation shifted = check_outline(
        rise, own, beside, limit_mm,
        {scaffold ? "the first interval's scaffold" : "the first interval's part",
         std::string("tool_") + (scaffold ? "scaffold" : "water") + " of the machine is not as calibrated",
         std::string("measure the nozzle of ") + (scaffold ? "valve_b" : "valve_a") +
             ", or run firn calibrate laser-offset",
         kOffsetKey});
    if (!shifted.empty()) return shifted;
  }
  HeightMap on_part = rise;
  for (std::size_t c = 0; c < on_part.size(); ++c)
    if (!material.cells[c]) on_part.cells[c] = kNotMeasured;
  return check_edges(
      on_part, limit_mm,
      {"the first interval",
       "laser_point.offset_x_mm, laser_point.offset_y_mm or a tool of the machine is not as calibrated",
       "run firn calibrate laser-offset, then print again; if it stays, the nozzle is aside", kOffsetKey});
}

}  // namespace

FirstMapDoubt doubt_of_first_map(const Experiment& e, const slice::PrintPaths& paths, const height_map_t& m,
                                 const HeightMap& bare) {
  const LaserPointConfig& laser = e.laser_point;
  FirstMapDoubt doubt;
  if (laser.bias_limit_mm == 0.0 && laser.offset_limit_mm == 0.0) return doubt;
  HeightMap height = on_readings(m);
  if (m.layer == 0) {
    doubt.stop =
        check_bare(height, laser.bias_limit_mm,
                   {"the bare table", "laser_point.offset_z_mm or ice.origin_z_mm is not as calibrated",
                    "run firn calibrate laser-offset", kBiasKey});
  } else {
    if (bare.size() != 0) {
      const HeightMap table = resample(bare, height.spec, kNotMeasured);
      for (std::size_t c = 0; c < height.size(); ++c) height.cells[c] -= table.cells[c];
    }
    doubt.stop = misplaced_material(e, paths, m.layer, height);
    const double laid_mm = m.layer * e.ice.layer_height_mm;
    if (doubt.stop.empty() && e.ice.map_table != "on" && laser.bias_limit_mm > 0.0) {
      HeightMap off = height;
      for (double& h : off.cells) h -= laid_mm;
      doubt.warning =
          check_bare(off, laser.bias_limit_mm + kFlowShare * laid_mm,
                     {"the first interval, less its nominal height,", "the laser's height or a valve's flow",
                      "ice.map_table = \"on\" tells which: it measures the bare table first", kBiasKey});
    }
  }
  return doubt;
}

// An empty tank or a blocked line shows in one interval; the saturation of the action, which also knows
// slower failures, takes several.
ValveDoubt disturbed_valve(const Experiment& e, const slice::PrintPaths& paths, int layer, int layers,
                           const HeightMap& newest, const HeightMap& before) {
  const slice::LayerPaths* top = slice::find_layer(paths, layer);
  if (!top || layers == 0) return {};
  ValveDoubt doubt;
  const double nominal_mm = layers * e.ice.layer_height_mm;
  const auto material = slice::footprint_materials(*top, newest.spec);
  const HeightMap below =
      before.size() ? resample(before, newest.spec, kNotMeasured) : HeightMap(newest.spec, 0.0);
  double rise_mm[2] = {}, cells[2] = {};  // part, scaffold
  for (std::size_t c = 0; c < newest.size(); ++c) {
    const double rise = newest.cells[c] - below.cells[c];
    if (!material.cells[c] || !std::isfinite(rise)) continue;
    const int which = material.cells[c] == 1 ? 0 : 1;
    rise_mm[which] += rise;
    cells[which] += 1.0;
  }
  for (const int which : {0, 1}) {
    if (cells[which] < kFewOfInk) continue;
    const double full_mm = nominal_mm * cells[which];
    doubt.much = rise_mm[which] > e.process.most_rise_share * full_mm;
    if (!doubt.much && rise_mm[which] >= e.ice.least_rise_share * full_mm) continue;
    doubt.violation.text = std::string(which ? "valve_b" : "valve_a") +
                           (doubt.much ? " gives too much: the " : " gives nothing: the ") +
                           (which ? "scaffold" : "part") + " rose by " +
                           std::to_string(rise_mm[which] / cells[which]) + " mm in layers " +
                           std::to_string(layer - layers + 1) + " to " + std::to_string(layer) +
                           " instead of " + std::to_string(nominal_mm) +
                           (doubt.much ? " mm; it leaks or stays open" : " mm; tank empty or line blocked");
    doubt.violation.figure = {rise_mm[which] / full_mm,
                              doubt.much ? e.process.most_rise_share : e.ice.least_rise_share, "",
                              doubt.much ? "process.most_rise_share" : "ice.least_rise_share"};
    return doubt;
  }
  return doubt;
}

Violation rise_without_command(const Experiment& e, int layer, const HeightMap& before,
                               const HeightMap& height) {
  const double min_mm = e.ice.least_rise_share * e.ice.layer_height_mm;
  if (min_mm == 0.0 || height.spec != before.spec) return {};
  double rise_mm = 0.0, cells = 0.0;
  for (std::size_t c = 0; c < height.size(); ++c) {
    const double rise = height.cells[c] - before.cells[c];
    if (!std::isfinite(rise)) continue;
    rise_mm += rise;
    cells += 1.0;
  }
  if (cells < kFewOfInk || rise_mm <= min_mm * cells) return {};
  return {"rise without command: the surface rose by " + std::to_string(rise_mm / cells) +
              " mm between two measurements of layer " + std::to_string(layer) +
              " with nothing to deposit: a valve leaks or stays open",
          {rise_mm / cells, min_mm, "mm", "ice.least_rise_share"}};
}

}  // namespace firn
