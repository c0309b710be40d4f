// Makes the inputs of a print along paths: deposition and measurement paths, and the machine.
#pragma once

#include <filesystem>

#include "config/experiment.h"
#include "core/slice/paths/print_paths.h"
#include "runtime/node.h"

namespace firn {

/// Slices ice.mesh: measurement paths in every ice.interval_layers-th layer and the last; every other layer
/// has one boundary path more, so that its fill lies aside of that below.
/// @param folder of the experiment file, to which ice.mesh and ice.slice are relative
/// @throws ConfigError, UsageError: files that cannot be read, a mesh of no layers, settings that do not fit
/// it
slice::PrintPaths slice_ice_part(const Experiment& experiment, const std::filesystem::path& folder);

/// Makes the blobs "paths" (core/slice/paths/print_paths.h), sliced or read from ice.paths, and "machine"
/// (the machine's TOML text).
/// @param folder of the experiment file, to which the files of [ice] are relative
/// @throws ConfigError, UsageError: as slice_ice_part and read_ice_paths
Blobs make_ice_inputs(const Experiment& experiment, const std::filesystem::path& folder);

/// Places the simulated surface (plant.ice.field_*) around all paths, unless the experiment sets its place.
void place_ice_field(Experiment& experiment, const Blobs& inputs);

/// Refuses paths that the arm cannot follow (core/planning/path_reach.h) before there is a run.
/// @throws UsageError naming layer, path, point and limit
void check_reach(const Experiment& experiment, const Blobs& inputs);

}  // namespace firn
