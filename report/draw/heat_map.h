// Draws surfaces as heat maps: one common colour scale, mm axes, a colour bar. Grids may have any size:
// the cells are one embedded PNG.
#pragma once

#include <string>

#include "core/grid/grid.h"
#include "report/draw/raster.h"

namespace firn::report {

/// Sequential: cividis, legible without colour vision. Diverging: blue - white - orange about zero.
enum class ColorMap { kSequential, kDiverging };

struct HeatScale {
  double low_um = 0, high_um = 1;
  ColorMap colors = ColorMap::kSequential;
  bool in_mm = false;  ///< the bar's numbers
};

/// Returns a pixel for each cell, y upwards, without axes.
/// @param height [mm]; NaN stays transparent
Raster colour_cells(const HeightMap& height, const HeatScale& scale);

/// Draws one surface.
/// @param height [mm]; NaN stays empty
/// @param part of the same grid: its cells are outlined; nullptr: no outline
std::string heat_map(const HeightMap& height, const HeatScale& scale, const std::string& title,
                     const Mask* part = nullptr);

/// Draws the colour bar of all maps of one scale.
std::string color_bar(const HeatScale& scale, const std::string& name);

}  // namespace firn::report
