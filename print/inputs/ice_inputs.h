// A run's inputs in the ice lab: the mesh sliced into deposition and measurement paths, and the machine.
#pragma once

#include <filesystem>

#include "config/experiment.h"
#include "core/slice/paths/print_paths.h"
#include "runtime/node.h"

namespace firn {

/// Blobs "paths" (core/slice/print_paths.h; measurement paths in every ice.interval_layers-th layer and the
/// last) and "machine" (the machine's TOML text). Every other layer has one boundary path more, so that its
/// fill lies aside of that below.
/// @param folder of the experiment file, to which ice.mesh, ice.slice and ice.machine are relative
/// @throws ConfigError, UsageError: files that cannot be read, a mesh of no layers, settings that do not fit
/// it
Blobs make_ice_inputs(const Experiment& experiment, const std::filesystem::path& folder);

/// Puts the simulated surface (plant.ice.field_*) round all paths, unless the experiment says where it is.
/// Nothing for an ink-jet lab.
void place_ice_field(Experiment& experiment, const Blobs& inputs);

/// What the planner would refuse before the print begins, said before there is a run. Nothing for an ink-jet
/// lab.
/// @throws UsageError naming layer, path, point and limit
void check_reach(const Experiment& experiment, const Blobs& inputs);

}  // namespace firn
