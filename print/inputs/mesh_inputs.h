// MeshInputs holds the readers of meshes for prints of droplets.
#pragma once

#include <filesystem>
#include <optional>

#include "config/experiment.h"
#include "core/grid/geometry.h"
#include "core/grid/shapes.h"

namespace firn {

struct MeshInputs {
  /// Makes part.mesh a target: the height of each cell's column. @throws ConfigError: a file that is no mesh,
  /// a part that does not fit or covers no cell; a column with a gap, which one ink cannot print
  Target (*target)(const Experiment& experiment, const std::filesystem::path& folder);
  /// Makes geometry.mesh the inks' geometry, as high as the block. @throws ConfigError: a file that is no
  /// mesh
  Geometry (*geometry)(const Experiment& experiment, const std::filesystem::path& folder, double height_mm);
};

}  // namespace firn
