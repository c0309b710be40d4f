// Reads the path file of `firn slice` as the paths of a print.
#pragma once

#include <filesystem>

#include "config/experiment.h"
#include "config/machine.h"
#include "core/slice/paths/print_paths.h"

namespace firn {

/// Reads a path file (docs/formats.md), up to ice.height_mm, and checks that the lab can print it: layers
/// of ice.layer_height_mm from the table upwards, one valve for each material, tools of the machine, and
/// measurement paths over every deposited material in the last layer of each interval of ice.interval_layers.
/// @throws ConfigError naming the file, and of damage the byte, else the layer, the value and the limit
slice::PrintPaths read_ice_paths(const Experiment& experiment, const Machine& machine,
                                 const std::filesystem::path& file);

}  // namespace firn
