// Writes deposition paths as G-code, for other printers and for viewers.
#pragma once

#include <string>

#include "config/slice.h"
#include "core/slice/paths/layer_paths.h"

namespace firn {

/// Returns the lines before the first layer: units, absolute coordinates, relative extrusion, additions of
/// the settings.
std::string gcode_start(const GcodeSettings& settings, const std::string& made_by);
/// Returns one layer, from any thread, independent of the layers before it. Coordinates have four decimals,
/// which is the grid. Tools are T0, T1, … by material; each path begins with a comment of its kind.
/// Measurement paths are comments only. E is the volume of width x layer height x length.
std::string gcode_layer(const slice::LayerPaths& layer, const GcodeSettings& settings);
std::string gcode_end(const GcodeSettings& settings);

}  // namespace firn
