// Estimates the heights that droplets at each place inside their cells add, from printed layers with droplets
// alone on bare ground (control.pattern.kind = "places").
#pragma once

#include <vector>

#include "core/deposition/offset_change.h"
#include "core/grid/offsets.h"
#include "estimators/droplet/identification.h"

namespace firn::droplet {

/// The droplets at one place.
struct PlaceRise {
  Rise rise;    ///< mean over the repeats of 5 x 5 cells
  Repeats own;  ///< rise of the own cell
  deposition::OffsetKernel
      kernel;                ///< the nearest to the mean that is nowhere negative and has the common height
  double mixed_error = 0.0;  ///< largest difference from mixed_kernel(), a share of the droplet's height
};

struct PlacePrints {
  std::vector<PlaceRise> places;    ///< by index of the table; without repeats where none was found
  Repeats drop_height;              ///< that a droplet adds over all cells, of all places together
  deposition::DropletModel centre;  ///< h1, h2, h3 of the droplets in the centre
  bool complete() const;            ///< two repeats at least of every place
};

/// Sites are found by their droplets: nothing else fired within four cells in this layer or any before it.
/// Sites with a cell that was not measured are left out.
/// @param offsets of each layer's droplets @pre as many as layers
PlacePrints find_place_prints(const std::vector<PrintedLayer>& layers, const std::vector<OffsetMap>& offsets,
                              const OffsetTable& table);

/// The nearest kernel, by the sum of squares, that is nowhere negative and adds `drop_height_mm` over all
/// cells (projection on a simplex). So small heights that are noise vanish without a change of the volume.
/// @pre drop_height_mm > 0
deposition::OffsetKernel nearest_kernel(const Rise& rise, double drop_height_mm);

}  // namespace firn::droplet
