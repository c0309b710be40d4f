// What the controller takes for the surface with control.height_estimate = "kalman": the map blended with
// what the executed droplets must have added (estimators/droplet/height_filter.h).
#pragma once

#include <optional>
#include <vector>

#include "config/experiment.h"
#include "estimators/droplet/droplet_factors.h"
#include "estimators/droplet/height_filter.h"
#include "estimators/droplet/layer_drops.h"
#include "firn/deposition_report_t.hpp"
#include "firn/height_map_t.hpp"

namespace firn {

class HeightEstimate {
 public:
  HeightEstimate(const Experiment& experiment, Mask mask);

  /// Reports of other grids and of layers already measured are passed over.
  void take(const deposition_report_t& report);
  /// From the next layer on.
  void use_model(const deposition::DropletModel& model, double droplet_scatter);

  /// Whether all reports of the map's layer have come (they travel on another channel than the map).
  bool ready(const height_map_t& map) const;
  /// Takes the map in. Where the layer's reports have not come, or layers lie between this map and the last
  /// one, the map alone counts. @throws std::invalid_argument: a map that cannot be used; nothing is changed
  /// then.
  void take(const height_map_t& map);

  HeightMap height() const;  ///< as the newest map and the droplets before it tell; finite
  /// control.droplet_factors: what droplets were found to add, as shares of the configured model's; null: not
  /// asked for.
  const droplet::DropletFactors* factors() const { return factors_ ? &*factors_ : nullptr; }
  double std_mm() const { return filter_.std_mm(mask_); }  ///< of one cell of the part

 private:
  std::vector<droplet::Pass> learned_from(const HeightMap& height, const std::vector<droplet::Use>& use);
  Mask mask_;
  GridSpec grid_;
  deposition::DropletModel model_;
  double droplet_scatter_;
  droplet::HeightFilter filter_;
  droplet::LayerDrops drops_;
  std::optional<droplet::DropletFactors> factors_;
  int layer_ = 0;   ///< of drops_
  int taken_ = -1;  ///< newest layer whose map was taken in
};

}  // namespace firn
