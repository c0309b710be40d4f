// A scheme beyond the thesis's PID: what each place will be short of is foreseen, and the share of an error
// that is taken for lasting adapts from place to place.
#pragma once

#include "core/control/surface/surface_memory.h"

namespace firn::control {

/// The surface obeys e_{k+1} = e_k - u'_k - d_k (5.16), u' being what was executed, saturation included. Each
/// cell keeps an estimate D of d. With the innovation v_k = e_{k-1} - u'_{k-1} - D_{k-1} - e_k, by which a
/// map differs from what was foreseen:
///   D_k = D_{k-1} + g v_k,       U_k = K_p e_k - D_k
/// At constant g this is a PI law whose integral knows what was executed, so it cannot wind up. An innovation
/// that comes again is a disturbance not yet learned, one that alternates is noise already answered too much:
/// with v averaged over a square of cells and rho = v_k v_{k-1} / max(v_k^2, v_{k-1}^2), g moves by gain_rate
/// * rho within [gain_min, gain_max], for each cell. D and g are resampled onto the new grid; new cells start
/// with D = 0 and the gain of the options. At k = 1 the table counts as flat: D_1 = -g e_1.
class AdaptiveSurface final : public SurfaceScheduler {
 public:
  explicit AdaptiveSurface(const SurfaceOptions& options) : SurfaceScheduler(options) {}
  const HeightMap& gain() const { return after_.gain; }
  const HeightMap& disturbance() const { return after_.disturbance; }

 private:
  HeightMap control_law(const SurfaceMeasurement& measurement, const HeightMap& error, bool again) override;
  void executed(const HeightMap& u) override;
  struct Memory {
    HeightMap error, disturbance, gain, innovation, executed;
  };
  Memory before_, after_;
};

}  // namespace firn::control
