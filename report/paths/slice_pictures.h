// Draws layers as pictures: outlines, and paths coloured by material and kind; several side by side as a
// contact sheet.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/slice/paths/layer_paths.h"
#include "core/slice/paths/path_plan.h"

namespace firn::report {

struct PicturedLayer {
  slice::LayerRegions regions;
  slice::LayerPaths paths;
};

/// Draws all layers at one scale, each with its number and height above it, and a bar of the scale below.
std::string layers_svg(std::span<const PicturedLayer> layers);
/// Draws the same sheet as PNG. @param width_px of the sheet, 100 to 10,000
std::string layers_png(std::span<const PicturedLayer> layers, int width_px);

/// Writes one layer's paths in the JSON format that firn plan reads. @param tools by material
std::string layer_json(const slice::LayerPaths& layer, std::span<const std::string> tools);

}  // namespace firn::report
