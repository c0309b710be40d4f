// Estimates the heights that droplets at each place inside their cells add, from printed layers with droplets
// alone on bare ground (control.pattern.kind = "places").
//
// A map has the mean of a cell along x and, along y, one line of the profiler through the cell's middle.
// Droplets at several places along y show the rise s(v) of a line at many distances v = dy - y from the
// droplet, dy the row of cells and y the place; the mean over a cell is the integral of s, smooth between
// these distances, over a pitch.
#pragma once

#include <string>
#include <vector>

#include "core/deposition/offset_change.h"
#include "core/grid/offsets.h"
#include "estimators/droplet/identification.h"

namespace firn::droplet {

/// The droplets at one place of the print.
struct PlaceRise {
  Rise rise;    ///< mean over the repeats of 5 x 5 cells of the map
  Repeats own;  ///< rise of the own cell
};

struct PlacePrints {
  std::vector<PlaceRise> places;      ///< by index of the printed table
  int droplets = 0;                   ///< alone and measured
  double drop_height_mm = 0.0;        ///< that a droplet adds over all cells, mean of the wanted places
  double small_drop_height_mm = 0.0;  ///< the same of small droplets; 0: there are none
  std::vector<deposition::OffsetKernel>
      kernels;          ///< of the wanted table, by index; none: something is missing
  std::string missing;  ///< that reason; "" = none
};

/// Sites are found by their droplets: nothing else fired within four cells in this layer or any before it.
/// Sites with a cell that was not measured are left out.
/// @param offsets of each layer's droplets @pre as many as layers
/// @param printed table of these offsets @param wanted table whose kernels are computed, beside the centre's:
/// its places along x must be those of `printed`, along y any. The kernel of a small droplet in the centre is
/// the mean of those of the places nearest to it where none are printed above and below the centre.
PlacePrints find_place_prints(const std::vector<PrintedLayer>& layers, const std::vector<OffsetMap>& offsets,
                              const OffsetTable& printed, const OffsetTable& wanted);

/// The nearest kernel, by the sum of squares, that is nowhere negative and adds `drop_height_mm` over all
/// cells (projection on a simplex). So small heights that are noise vanish without a change of the volume.
/// @pre drop_height_mm > 0
deposition::OffsetKernel nearest_kernel(const deposition::OffsetKernel& measured, double drop_height_mm);

}  // namespace firn::droplet
