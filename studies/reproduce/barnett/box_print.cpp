#include "studies/reproduce/barnett/box_print.h"

#include <algorithm>
#include <string>

#include "files/mesh/mesh_file.h"
#include "print/inputs/ice_inputs.h"
#include "print/labs/full_product.h"
#include "runs/folder/run_folder.h"

namespace firn::barnett {
namespace {

namespace fs = std::filesystem;

constexpr const char* kSlice =
    "[mesh]\nplace_x = \"cent\"\nplace_y = \"cent\"\nplace_z = \"number\"\nz_mm = "
    "[0.0]\n[part]\nfirst_offset_mm = 0.75\n[scaffold]\nfirst_offset_mm = 0.9\n[support]\nkind = "
    "\"full\"\nbuffer_mm = 3.3\n";

// 5.3: SMF, MTTS and VFVC all online: valve frequency follows speed and feedback.
Experiment experiment_of(double height_mm, std::uint64_t seed) {
  Experiment e;
  e.lab.kind = "ice";
  e.run.name = "box";
  e.plant.seed = e.control.seed = seed;
  e.ice.mesh = "box.stl";
  e.ice.slice = "slice.toml";
  e.ice.machine = "machine.toml";
  e.ice.layer_height_mm = kBoxLayer_mm;
  e.ice.height_mm = height_mm;
  e.ice.interval_layers = 5;
  e.ice.measure_spacing_mm = 1.5;  // rings of it fill wall and scaffold
  e.ice.water = {25.0, 40.0, 50.0};
  e.ice.scaffold = {25.0, 40.0, 125.0};
  e.laser_point.latency_s = -0.0293;  // as calibrated: labs/ice-cobra600.toml
  e.valve_a.latency_s = -0.0264;
  e.valve_b.latency_s = -0.0263;
  e.process.max_rescans = 1;
  e.process.min_measured_fraction = 0.6;  // half of the paths run along edges
  e.control.scheme = "smf";
  e.control.smoothing = 1.0;
  e.control.smf.kp = 0.9999;
  e.control.smf.ki_star = 0.32798;
  e.control.smf.kd_star = 0.00005;
  e.control.surface.version = control::SurfaceVersion::kValveFrequency;
  e.control.smf.output_limit = e.control.smf.integral_limit = 0.5;
  return e;
}

}  // namespace

BoxFolder::BoxFolder(const BoxPart& part, bool plate_on_top) : folder_("part"), path(folder_.path()) {
  write_file_atomically(path / "box.stl", mesh_bytes(mesh_of(part, plate_on_top), MeshFormat::kBinaryStl));
  write_file_atomically(path / "slice.toml", kSlice);
  write_file_atomically(path / "machine.toml", kBoxMachine);
}

MemoryPrintReport print_box(const BoxPart& part, std::uint64_t seed, const std::function<void()>& layer) {
  const BoxFolder folder(part, false);
  Experiment e = experiment_of(part.height_mm, seed);
  const Blobs inputs = make_ice_inputs(e, folder.path);
  place_ice_field(e, inputs);
  const IcePlantConfig& f = e.plant.ice;
  MemoryPrintOptions options;
  options.series = options.surface = options.ice_each = true;
  options.ice_over = GridSpec{
      int(f.field_width_mm / f.cell_mm) - 2, int(f.field_depth_mm / f.cell_mm) - 2, f.cell_mm, f.cell_mm,
      f.field_x0_mm + 1.5 * f.cell_mm,       f.field_y0_mm + 1.5 * f.cell_mm};
  options.tap = [&](std::string_view channel, std::span<const std::byte>) {
    if (layer && channel == "LAYER_METRICS") layer();
  };
  return print_in_memory(full_product(), e, inputs, options);
}

std::vector<WallBand> wall_bands(const BoxPart& part, const MemoryPrintReport& print) {
  constexpr std::size_t kPlaces = 4;
  const std::vector<LayerTruth>& after = print.series;
  std::size_t first = 0;  // interval that ends above the plate
  while (first < after.size() && after[first].layer * kBoxLayer_mm < part.plate_mm - 1e-9) ++first;
  std::vector<WallBand> bands;
  if (after.size() <= first + 1 || print.ice_each.size() != after.size()) return bands;
  const std::size_t intervals = after.size() - 1 - first, places = std::min(kPlaces, intervals);
  for (std::size_t n = 0; n < places; ++n) {
    const std::size_t below = first + n * intervals / places, top = first + (n + 1) * intervals / places;
    WallBand band{(after[top].layer - after[below].layer) * kBoxLayer_mm, print.ice_each[top]};
    for (std::size_t c = 0; c < band.ice.cells.size(); ++c)
      band.ice.cells[c] -= print.ice_each[below].cells[c];
    bands.push_back(std::move(band));
  }
  return bands;
}

}  // namespace firn::barnett
