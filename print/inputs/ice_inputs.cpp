#include "print/inputs/ice_inputs.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "config/error.h"
#include "config/ice_lab.h"
#include "core/planning/path_reach.h"
#include "core/slice/paths/interval_paths.h"
#include "files/usage_error.h"
#include "print/inputs/mesh_part.h"
#include "print/inputs/path_input.h"
#include "print/inputs/python_input.h"
#include "print/inputs/targets.h"
#include "print/prepare/slice_job.h"
#include "procs/controller/surface_node.h"
#include "runtime/thread_pool.h"

namespace firn {
namespace {

constexpr double kFieldMargin_mm = 4.0;
constexpr double kFieldStep_mm = 1.0;   // so that a slightly other part has the same field
constexpr double kFieldShift_mm = 0.5;  // cells of the truth that is logged are those of maps of 1 mm

Machine machine_of(const Experiment& e, const std::vector<std::byte>& text) {
  return parse_machine({reinterpret_cast<const char*>(text.data()), text.size()}, e.ice.machine);
}

// The part's box against the arm's: a mesh in another unit is refused before it is sliced.
void check_box(const Experiment& e, const Machine& machine, const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / e.ice.mesh;
  const SliceSettings settings = load_slice_settings(folder / e.ice.slice);
  const MeshFile mesh(file, facet_count(settings));
  const slice::Affine box = [&] {
    try {
      return slice::place(mesh.facets(),
                          placement(settings, 0, mesh.data().format == "3MF" ? mesh.data().mm_per_unit : 0.0),
                          serially);
    } catch (const std::invalid_argument& error) {
      throw ConfigError(file.string(), 0, "ice.mesh", std::string("ice.mesh: ") + error.what());
    }
  }();
  if (box.low.x > box.high.x) return;  // no facet is finite: the slicer says so
  const auto side_mm = [](std::int32_t low, std::int32_t high) {
    return (double(high) - low) * geometry::kMmPerUnit;
  };
  BoxSize size{side_mm(box.low.x, box.high.x), side_mm(box.low.y, box.high.y),
               side_mm(box.low.z, box.high.z)};
  if (e.ice.height_mm > 0.0) size[2] = std::min(size[2], e.ice.height_mm);
  const double reach_mm = 2.0 * (machine.link_1_mm + machine.link_2_mm);
  check_fits(size, {reach_mm, reach_mm, machine.joint[2].high - machine.joint[2].low}, file.string(),
             "ice.mesh", "the arm's reach, with its stroke in z,");
}

}  // namespace

slice::PrintPaths slice_ice_part(const Experiment& e, const std::filesystem::path& folder) {
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
  paths.head = path_file_head(job, settings);
  paths.head.laser = settings.laser_tool;
  const slice::PathOptions options = path_options(settings);
  const slice::PathOptions shifted = slice::with_shifted_fill(options);
  const int last = paths.head.layers;
  plan_layers(
      job, settings, parallel, [](double, const std::string&) {}, {},
      [&](PlannedLayer&& l) {
        if (l.paths.layer % 2 == 0) l.paths = slice::plan_layer(l.regions, shifted);
        if (l.paths.layer % e.ice.interval_layers == 0 || l.paths.layer == last)
          slice::add_measurement(l.regions, options, {e.ice.measure_spacing_mm, e.ice.measure_offset_mm},
                                 l.paths);
        paths.layers.push_back(std::move(l.paths));
      });
  return paths;
}

Blobs make_ice_inputs(const Experiment& e, const std::filesystem::path& folder) {
  std::vector<std::byte> text = read_bytes(folder / e.ice.machine, "ice.machine");
  const Machine machine = machine_of(e, text);
  if (machine.kind != "scara")
    throw ConfigError((folder / e.ice.machine).string(), 0, "ice.machine",
                      "ice.machine: the ice lab has an arm (kind = \"scara\")");
  if (e.ice.paths.empty()) check_box(e, machine, folder);
  const slice::PrintPaths paths =
      e.ice.paths.empty() ? slice_ice_part(e, folder) : read_ice_paths(e, machine, folder / e.ice.paths);
  Blobs blobs;
  blobs.push_back(make_blob("paths", slice::encode(paths)));
  blobs.push_back(make_blob("machine", std::move(text)));
  add_python_inputs(
      e, folder, {}, [&](const Blobs& files) { SurfaceControllerNode(e, paths, files); }, blobs);
  return blobs;
}

void place_ice_field(Experiment& e, const Blobs& inputs) {
  IcePlantConfig& p = e.plant.ice;
  if (p.field_width_mm > 0.0) return;
  std::int32_t x0 = std::numeric_limits<std::int32_t>::max(), y0 = x0, x1 = -x0, y1 = -x0;
  for (const slice::LayerPaths& l : slice::decode_print_paths(blob(inputs, "paths").bytes).layers)
    for (const geometry::Point& q : l.lines.points) {
      x0 = std::min(x0, q.x);
      x1 = std::max(x1, q.x);
      y0 = std::min(y0, q.y);
      y1 = std::max(y1, q.y);
    }
  const auto low = [](std::int32_t q) {
    return std::floor((q * geometry::kMmPerUnit - kFieldMargin_mm) / kFieldStep_mm) * kFieldStep_mm -
           kFieldShift_mm;
  };
  p.field_x0_mm = low(x0);
  p.field_y0_mm = low(y0);
  p.field_width_mm = -low(-x1) - p.field_x0_mm;
  p.field_depth_mm = -low(-y1) - p.field_y0_mm;
}

void check_reach(const Experiment& e, const Blobs& inputs) {
  const slice::PrintPaths paths = slice::decode_print_paths(blob(inputs, "paths").bytes);
  const planning::PlanningSetup setup = planning_setup(e, machine_of(e, blob(inputs, "machine").bytes));
  const auto refused = planning::unreachable_paths(planning::TaskPlanner(setup), paths, setup, 1);
  if (!refused.empty()) throw UsageError(planning::refusal(refused.front()));
}

}  // namespace firn
