// EdgeReference computes targets for the layers of a rising part, such that its edge lags behind and ink
// beside the outline is saved.
#pragma once

#include <optional>

#include "core/control/controller.h"

namespace firn::control {

/// A droplet gives a lower neighbour all of its share and a higher one less: nothing, where that stands h1 +
/// w higher [Lu 2015, (4), (5)]. An edge that lags by as much gets ink from inside with every layer and gives
/// none back, so it is filled in fewer droplets, each of which loses the same to the ground beside the part
/// (docs/algorithms/edges.md). A cell lags by `lag_layers` layers for each of its four sides that lies
/// outside, so that a convex corner lags behind the edges that meet in it.
/// The third row from the outline lags by `lag_layers` too: the second is then a ridge that gives ink to both
/// sides and gets none. Keeps no state.
class EdgeReference {
 public:
  /// @param lag_layers 0 or more, @param rise_layers of the reference from layer to layer, above 0
  EdgeReference(const Setup& setup, double lag_layers, double rise_layers);

  /// Returns the target of the next layer: min(target, level + rise) - lag, at least 0, where the level is
  /// the mean of height + lag over the cells that are more than half a layer below target - lag. None: there
  /// is no such cell, and the part has risen.
  /// @param target of the part or a stage of it; on the setup's grid @param height finite on the mask
  std::optional<HeightMap> next(const HeightMap& target, const HeightMap& height) const;

  const HeightMap& lag_mm() const { return lag_; }

 private:
  Mask mask_;
  HeightMap lag_;
  double layer_mm_, rise_mm_;
};

}  // namespace firn::control
