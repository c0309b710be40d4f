#include "print/labs/ice_print.h"

#include "core/slice/paths/print_paths.h"
#include "print/inputs/ice_inputs.h"

namespace firn {
namespace {

constexpr double kUm = 1e3;  // per mm

Blobs sliced_inputs(const Experiment& e, const std::filesystem::path& folder, const MeshInputs*) {
  return make_ice_inputs(e, folder);
}

double tolerance_um(const Experiment& e) { return e.ice.layer_height_mm * kUm; }

Experiment fullest() {
  Experiment e;
  e.lab.kind = "ice";
  e.control.scheme = "smf";
  e.flow.feed_forward = "on";
  e.ice.mesh = "-";
  e.ice.slice = "-";
  e.ice.machine = "-";
  return e;
}

/// One square layer; the machine of the defaults.
Blobs example_inputs(const Experiment&) {
  slice::PrintPaths paths;
  paths.head.layers = 1;
  paths.head.materials = {{"part", "water"}, {"scaffold", "scaffold"}};
  paths.head.laser = "laser";
  slice::LayerPaths layer;
  layer.layer = 1;
  layer.z = layer.height = 2400;
  const geometry::Point corners[] = {{0, 0}, {100000, 0}, {100000, 100000}, {0, 100000}};
  layer.lines.add(corners);
  layer.info.push_back({PathKind::kBoundary, 0, true, 15000});
  paths.layers.push_back(std::move(layer));
  return {{"paths", "", slice::encode(paths)}, {"machine", "", {}}};
}

}  // namespace

const PrintLab kIcePrint{"ice",         &sliced_inputs, &place_ice_field, &check_reach,
                         &tolerance_um, &fullest,       &example_inputs,  &report::kPathReport};

}  // namespace firn
