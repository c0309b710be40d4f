#include "print/inputs/ice_inputs.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "config/error.h"
#include "config/machine.h"
#include "files/digest.h"
#include "files/usage_error.h"
#include "print/inputs/targets.h"
#include "print/prepare/slice_job.h"
#include "procs/path_planner/node.h"
#include "runtime/build_info.h"
#include "runtime/thread_pool.h"

namespace firn {
namespace {

constexpr double kFieldMargin_mm = 4.0;
constexpr double kFieldStep_mm = 1.0;   // so that a slightly other part has the same field
constexpr double kFieldShift_mm = 0.5;  // cells of the truth that is logged are those of maps of 1 mm

Blob make_blob(std::string role, std::vector<std::byte> bytes) {
  std::string name = sha256_hex(bytes);
  return {std::move(role), std::move(name), std::move(bytes)};
}

/// Concentric paths of one material each, the part's first: long ones over a surface that reflects alike
/// [5.2.1].
void add_measurement(const slice::LayerRegions& regions, const slice::PathOptions& deposit, double spacing_mm,
                     double offset_mm, slice::LayerPaths& out) {
  slice::PathOptions options = deposit;
  options.hook.on = options.measure.on = false;
  for (slice::BeadOptions* bead : {&options.part, &options.scaffold}) {
    bead->first_offset_mm = offset_mm > 0.0 ? offset_mm : std::max(bead->first_offset_mm, 0.25 * spacing_mm);
    bead->boundary_width_mm = bead->fill_width_mm = spacing_mm;
    bead->boundaries = 1;
    bead->pattern = slice::FillPattern::kConcentric;
  }
  const slice::LayerPaths measured = slice::plan_layer(regions, options);
  for (std::size_t material = 0; material < regions.by_material.size(); ++material)
    for (std::size_t n = 0; n < measured.info.size(); ++n) {
      slice::PathInfo info = measured.info[n];
      if (info.material != material || measured.lines[n].size() < 3) continue;
      info.kind = PathKind::kMeasurement;
      info.width = 0;
      out.lines.add(measured.lines[n]);
      out.info.push_back(info);
    }
}

/// One boundary more: the fill lies half a bead aside. Beads that lie above each other in all layers leave
/// grooves between them that only grow, too narrow for the maps to show.
slice::PathOptions with_shifted_fill(slice::PathOptions options) {
  ++options.part.boundaries;
  ++options.scaffold.boundaries;
  return options;
}

}  // namespace

Blobs make_ice_inputs(const Experiment& e, const std::filesystem::path& folder) {
  std::vector<std::byte> machine = read_bytes(folder / e.ice.machine, "ice.machine");
  const Machine m =
      parse_machine({reinterpret_cast<const char*>(machine.data()), machine.size()}, e.ice.machine);
  if (m.kind != "scara")
    throw ConfigError((folder / e.ice.machine).string(), 0, "ice.machine",
                      "ice.machine: the ice lab has an arm (kind = \"scara\")");
  const SliceSettings settings = load_slice_settings(
      folder / e.ice.slice, {fmt::format("layer.height_mm={}", e.ice.layer_height_mm), "measure.on=0"});
  const ParallelFor parallel = parallel_on(0);
  SlicedJob job = slice_meshes({folder / e.ice.mesh}, settings, parallel, [](double, const std::string&) {});
  if (e.ice.height_mm > 0.0)
    job.layers.resize(
        std::min(job.layers.size(), std::size_t(std::floor(e.ice.height_mm / e.ice.layer_height_mm + 1e-9))));
  if (job.layers.empty())
    throw ConfigError((folder / e.ice.mesh).string(), 0, "ice.mesh", "ice.mesh: has no layer");

  slice::PrintPaths paths;
  paths.head.made_by = "firn " + build_commit();
  paths.head.layers = std::int32_t(job.layers.size());
  paths.head.materials = {{"part", settings.part.tool}, {"scaffold", settings.scaffold.tool}};
  paths.head.laser = settings.laser_tool;
  paths.head.settings = dump(settings);
  const slice::PathOptions options = path_options(settings);
  const slice::PathOptions shifted = with_shifted_fill(options);
  const int last = paths.head.layers;
  plan_layers(
      job, settings, parallel, [](double, const std::string&) {}, {},
      [&](PlannedLayer&& l) {
        if (l.paths.layer % 2 == 0) l.paths = slice::plan_layer(l.regions, shifted);
        if (l.paths.layer % e.ice.interval_layers == 0 || l.paths.layer == last)
          add_measurement(l.regions, options, e.ice.measure_spacing_mm, e.ice.measure_offset_mm, l.paths);
        paths.layers.push_back(std::move(l.paths));
      });
  Blobs blobs;
  blobs.push_back(make_blob("paths", slice::encode(paths)));
  blobs.push_back(make_blob("machine", std::move(machine)));
  return blobs;
}

void place_ice_field(Experiment& e, const Blobs& inputs) {
  IcePlantConfig& p = e.plant.ice;
  if (!is_ice(e) || p.field_width_mm > 0.0) return;
  std::int32_t x0 = std::numeric_limits<std::int32_t>::max(), y0 = x0, x1 = -x0, y1 = -x0;
  for (const slice::LayerPaths& l : slice::decode_print_paths(blob(inputs, "paths").bytes).layers)
    for (const slice::Point& q : l.lines.points) {
      x0 = std::min(x0, q.x);
      x1 = std::max(x1, q.x);
      y0 = std::min(y0, q.y);
      y1 = std::max(y1, q.y);
    }
  const auto low = [](std::int32_t q) {
    return std::floor((q * slice::kMmPerUnit - kFieldMargin_mm) / kFieldStep_mm) * kFieldStep_mm -
           kFieldShift_mm;
  };
  p.field_x0_mm = low(x0);
  p.field_y0_mm = low(y0);
  p.field_width_mm = -low(-x1) - p.field_x0_mm;
  p.field_depth_mm = -low(-y1) - p.field_y0_mm;
}

void check_reach(const Experiment& e, const Blobs& inputs) {
  if (!is_ice(e)) return;
  const std::vector<std::byte>& text = blob(inputs, "machine").bytes;
  const slice::PrintPaths paths = slice::decode_print_paths(blob(inputs, "paths").bytes);
  const planning::PlanningSetup setup = planning_setup(
      e, parse_machine({reinterpret_cast<const char*>(text.data()), text.size()}, e.ice.machine));
  const planning::TaskPlanner planner(setup);
  for (const slice::LayerPaths& layer : paths.layers)
    for (const bool measurement : {false, true}) {
      const std::vector<planning::PathTask> tasks = planning::tasks_of(paths, layer, measurement, setup);
      for (std::size_t n = 0; n < tasks.size(); ++n)
        if (const std::string why = planner.unreachable(tasks[n]); !why.empty())
          throw UsageError(fmt::format("a path is out of reach, nothing is printed: layer {}, {} path {}: {}",
                                       layer.layer, measurement ? "measurement" : "deposition", n + 1, why));
    }
}

}  // namespace firn
