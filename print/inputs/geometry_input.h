// Computes the geometry of a print with two inks, from an analytic solid, a folder of images or a mesh.
#pragma once

#include <filesystem>
#include <optional>

#include "config/experiment.h"
#include "core/grid/geometry.h"
#include "print/inputs/mesh_inputs.h"

namespace firn {

/// Computes M on the experiment's grid, as high as the block `target`. Columns are sampled four times per
/// layer of h1 + 4 h2 + 4 h3; those of a mesh are exact. Empty for geometry.shape "none".
/// @param folder of the experiment file, to which geometry.images is relative.
/// @param meshes nullptr: the program reads none
/// @throws ConfigError: sizes that no solid has, a folder without PNGs, an image or mesh that cannot be read,
/// no object in the block; UsageError: a mesh without a reader.
std::optional<Geometry> make_geometry(const Experiment& experiment, const HeightMap& target,
                                      const std::filesystem::path& folder, const MeshInputs* meshes);

}  // namespace firn
