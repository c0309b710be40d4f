// AdaptiveSurface computes control surfaces from a disturbance estimate per cell whose gain adapts from place
// to place. It goes beyond the thesis's PID.
#pragma once

#include <array>

#include "core/control/surface/surface_controller_base.h"

namespace firn::control {

inline constexpr std::array kAdaptiveOptions{
    ExtraOption{"adaptive_gain", 0.33, "", above(0, 1),
                "smf_adaptive: first share of an innovation taken to last"},
    ExtraOption{"adaptive_window_cells", std::int64_t(3), "cells", within(0, 100),
                "compares innovations over squares of 2 n + 1"},
};
/// Returns `options` with the values of kAdaptiveOptions that it has in `extra`; bounds reach to the first
/// gain.
/// @throws std::invalid_argument: a value out of its range
SurfaceOptions with_adaptive(SurfaceOptions options);

/// The surface obeys e_{k+1} = e_k - u'_k - d_k (5.16), u' being the executed action, saturation included.
/// Each cell keeps an estimate D of d. With the innovation v_k = e_{k-1} - u'_{k-1} - D_{k-1} - e_k, the
/// prediction error of a map:
///   D_k = D_{k-1} + g v_k,       U_k = K_p e_k - D_k
/// At constant g this is a PI law whose integral uses the executed action, so it cannot wind up. A repeated
/// innovation is a disturbance not yet estimated. An alternating one is noise that is corrected too much.
/// With v averaged over a square of cells and rho = v_k v_{k-1} / max(v_k^2, v_{k-1}^2), g moves by gain_rate
/// * rho within [gain_min, gain_max], for each cell. D and g are resampled onto the new grid; new cells start
/// with D = 0 and the gain of the options. At k = 1 the table is assumed flat: D_1 = -g e_1.
class AdaptiveSurface final : public SurfaceControllerBase {
 public:
  explicit AdaptiveSurface(const SurfaceOptions& options) : SurfaceControllerBase(with_adaptive(options)) {}
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
