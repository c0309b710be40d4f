// DisturbanceObserverSurface computes control surfaces by a disturbance observer with feed-forward. It
// estimates the lasting disturbance from means over many cells, so that the roughness of one interval, which
// cannot be predicted, is corrected once and not again. It goes beyond the thesis's PID.
#pragma once

#include <array>

#include "core/control/surface/surface_controller_base.h"

namespace firn::control {

inline constexpr int kZoneBands = 5;
inline constexpr int kZones = 2 * 2 * kZoneBands;

/// Zone of each cell of a footprint, -1 beyond it: its material, whether the nearest border of that material
/// is one to the other material or to bare cells, and in which band of `band_mm` the distance between the
/// centres of the cell and of the nearest cell beyond the border lies; the last band has no end.
Grid<std::int8_t> zones(const Grid<std::uint8_t>& material, double band_mm);

/// Mean over the finite cells of a square of `side_mm` about each finite cell; NaN where the cell is not
/// finite.
HeightMap square_mean(const HeightMap& values, double side_mm);

/// The surface obeys e_{k+1} = e_k - u'_k - d_k (5.16), u' being the executed action. D is the estimate of d
/// and v_k = e_{k-1} - u'_{k-1} - e_k - D_{k-1} the innovation:
///   D = M[material] + Z[zone] + W(x, y)
///   M += phi S + flow_gain m,   S = phi S + beta flow_gain m,   m = mean of v over the material (drift)
///   Z += zone_gain * mean over the zone of the rest of v beyond m             (repeated lack at edges)
///   W += wide_gain * mean over squares of wide_mm of the rest of v beyond Z  (fixed pattern)
///   U_k = K_p (n + narrow_gain (e_k - n)) - D,   n = mean of e_k over squares of narrow_mm
/// The first map's means over a material are weighted by 0.3, and W stays 0: that map contains the table's
/// own shape, which does not last. A map of the bare table (layer 0) before it is answered but changes no
/// estimate, except that Z starts at the usual lack at borders (0.05 intervals, half of it in the band
/// behind). The rest of the first interval's error is then the valves', and its map has full weight, with
/// beta = 1.2 instead of 0.4. Zones belong to the footprint. W belongs to the place and is resampled onto the
/// new grid.
class DisturbanceObserverSurface final : public SurfaceControllerBase {
 public:
  explicit DisturbanceObserverSurface(const SurfaceOptions& options) : SurfaceControllerBase(options) {}
  const HeightMap& disturbance() const { return after_.disturbance; }

 private:
  HeightMap control_law(const SurfaceMeasurement& measurement, const HeightMap& error, bool again) override;
  void executed(const HeightMap& u) override { after_.executed = u; }
  struct Memory {
    std::array<double, 2> material{}, slope{};  ///< M and how it moves per interval
    std::array<double, kZones> zone{};
    HeightMap wide, error, executed, disturbance;
    bool of_table = false;  ///< `error` is the bare table's
  };
  Memory before_, after_;
};

}  // namespace firn::control
