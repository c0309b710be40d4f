// SmfSurface computes control surfaces by surface-mapping feedback for continuous deposition: a PID law whose
// signals are surfaces [Barnett 2012, 5.1.2, 5.2.2].
#pragma once

#include "core/control/surface/surface_controller_base.h"

namespace firn::control {

/// Open loop: the action is 0 for every measurement.
class OpenLoopSurface final : public SurfaceControllerBase {
 public:
  explicit OpenLoopSurface(const SurfaceOptions& options) : SurfaceControllerBase(options) {}

 private:
  HeightMap control_law(const SurfaceMeasurement& measurement, const HeightMap& error, bool again) override;
};

/// U_k = K_p E_k + K_i* sum_{i<=k} E_i + K_d* (E_k - E_{k-1})      (5.1), (5.2)
/// E normalised by the interval. The grid changes from interval to interval: sum and E_{k-1} are resampled
/// onto the new one first. A cell that had none starts with the sum at zero and without a derivative, as
/// every cell does at k = 1. The sum is held where |K_i* sum| reaches its limit (5.2.2).
class SmfSurface final : public SurfaceControllerBase {
 public:
  explicit SmfSurface(const SurfaceOptions& options) : SurfaceControllerBase(options) {}
  const HeightMap& integral() const { return after_.sum; }  ///< sum of E, NaN beyond the footprint

 private:
  HeightMap control_law(const SurfaceMeasurement& measurement, const HeightMap& error, bool again) override;
  struct Memory {
    HeightMap sum, error;
  };
  Memory before_, after_;
};

}  // namespace firn::control
