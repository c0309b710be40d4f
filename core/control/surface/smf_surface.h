// Surface-mapping feedback for continuous deposition: a PID law whose signals are surfaces [Barnett
// 2012, 5.1.2, 5.2.2].
#pragma once

#include "core/control/surface/surface_memory.h"

namespace firn::control {

/// Nothing is corrected, whatever is measured.
class OpenLoopSurface final : public SurfaceScheduler {
 public:
  explicit OpenLoopSurface(const SurfaceOptions& options) : SurfaceScheduler(options) {}

 private:
  HeightMap control_law(const SurfaceMeasurement& measurement, const HeightMap& error, bool again) override;
};

/// U_k = K_p E_k + K_i* sum_{i<=k} E_i + K_d* (E_k - E_{k-1})      (5.1), (5.2)
/// E normalised by the interval. The grid changes from interval to interval: sum and E_{k-1} are resampled
/// onto the new one first. A cell that had none starts with the sum at zero and without a derivative, as
/// every cell does at k = 1. The sum is held where |K_i* sum| reaches its limit (5.2.2).
class SmfSurface final : public SurfaceScheduler {
 public:
  explicit SmfSurface(const SurfaceOptions& options) : SurfaceScheduler(options) {}
  const HeightMap& integral() const { return after_.sum; }  ///< sum of E, NaN beyond the footprint

 private:
  HeightMap control_law(const SurfaceMeasurement& measurement, const HeightMap& error, bool again) override;
  struct Memory {
    HeightMap sum, error;
  };
  Memory before_, after_;
};

}  // namespace firn::control
