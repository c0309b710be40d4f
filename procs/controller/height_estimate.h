// HeightEstimate computes the controller's surface with control.height_estimate = "kalman": the map blended
// with the height predicted from the executed droplets (estimators/droplet/height_filter.h).
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

  /// Adds a report. Reports of other grids and of layers already measured are ignored.
  void take(const deposition_report_t& report);
  /// Uses the model from the next layer on.
  void use_model(const deposition::DropletModel& model, double droplet_scatter);

  /// Returns true if all reports of the map's layer have arrived (reports and maps have separate channels).
  bool ready(const height_map_t& map) const;
  /// Updates the estimate with the map. If reports of the layer are missing, or layers lie between this map
  /// and the last one, the map alone counts. @throws std::invalid_argument: an unusable map; nothing is
  /// changed then.
  void take(const height_map_t& map);

  HeightMap height() const;  ///< estimate from the newest map and the droplets before that map; finite
  /// Returns the estimated heights of droplets as shares of the configured model's (control.droplet_factors);
  /// null if not requested.
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
  int taken_ = -1;  ///< newest layer whose map was used
};

}  // namespace firn
