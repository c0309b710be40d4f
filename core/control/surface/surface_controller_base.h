// SurfaceControllerBase computes everything of a surface scheme but its control law: checks, statistics,
// resampling from interval to interval, saturation, and the action beyond the footprint.
#pragma once

#include "core/control/surface/surface_controller.h"

namespace firn::control {

/// @throws std::invalid_argument naming the option and its limit.
void check(const SurfaceOptions& options);
/// @throws std::invalid_argument, as SurfaceController::decide.
void check(const SurfaceMeasurement& measurement, int last_layer_seen);

/// Values that are carried to the next interval. Beyond the footprint they are not known (NaN).
HeightMap on_footprint(const HeightMap& values, const Grid<std::uint8_t>& material);
/// Old values on the new grid; cells that had none start at zero (5.1.2).
HeightMap carried_over(const HeightMap& from, const GridSpec& to);

/// e = (h_k - H) / dh_m on the footprint, NaN beyond [5.2.1].
HeightMap error_surface(const SurfaceMeasurement& measurement, double interval_mm);

/// Base of the schemes: knows interval and attempt, counts saturated maps, fills the decision.
class SurfaceControllerBase : public SurfaceController {
 public:
  explicit SurfaceControllerBase(const SurfaceOptions& options);
  SurfaceDecision decide(const SurfaceMeasurement& measurement) final;
  void use_flow(const std::array<double, 2>& factor) final;
  void use_options(const SurfaceOptions& options) final;
  void looked_after() final { before_ = after_ = {}; }

 protected:
  /// In intervals: laws add it to the error that they act on. Errors that they compare with earlier ones hold
  /// none, so that a change of it is no innovation.
  double target_offset() const { return options_.target_offset_mm / options_.interval_mm; }
  /// U of (5.1), not saturated, NaN beyond the footprint. `again`: the layer was measured before, and the
  /// state of that call does not count.
  virtual HeightMap control_law(const SurfaceMeasurement& measurement, const HeightMap& error,
                                bool again) = 0;
  /// The saturated U' as the printer will execute it, relative to the deposition of the estimated flow at u =
  /// 0.
  virtual void executed(const HeightMap& /*u*/) {}

  SurfaceOptions options_;

 private:
  struct Count {
    int part = 0,
        scaffold = 0;  ///< maps running in which more than stop_share of its cells asked for all there is
  };
  std::array<double, 2> factor_{1.0, 1.0};
  int layer_ = -1;
  Count before_, after_;
};

}  // namespace firn::control
