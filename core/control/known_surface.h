// KnownSurface computes the surface that a scheme decides on where a scan has not measured every cell.
#pragma once

#include <cstdint>
#include <span>

#include "core/control/controller.h"

namespace firn::control {

/// Replaces the heights of cells without a sample by the height-change model's: from the surface before the
/// layer and the droplets of its plan. A height guessed from neighbours has no weight in a decision.
class KnownSurface {
 public:
  explicit KnownSurface(const Setup& setup)
      : grid_(setup.grid),
        inks_{setup.model, setup.model_b},
        offsets_(setup.offsets),
        offsets_b_(setup.offsets_b),
        border_(setup.border) {}

  /// Returns `map` with the model's heights in the guessed cells. Without a surface of the layer before, as
  /// for the first map, they keep the map's.
  /// @param quality of each cell, a CellQuality
  /// @param layer layers deposited so far
  HeightMap filled(HeightMap map, std::span<const std::int8_t> quality, int layer);

  /// Keeps the surface of a decision and the droplets that it prints next. A second surface of one layer
  /// replaces the first.
  void keep(HeightMap surface, int layer, DropletPattern drops, MaterialMap materials, OffsetMap offsets);

 private:
  struct Printed {
    int layer = -1;
    HeightMap surface;
    DropletPattern drops;
    MaterialMap materials;
    OffsetMap offsets;
  };
  HeightMap after(const Printed& layer) const;

  GridSpec grid_;
  deposition::TwoInks inks_;
  deposition::OffsetModel offsets_, offsets_b_;
  deposition::Border border_;
  Printed before_, last_;
};

}  // namespace firn::control
