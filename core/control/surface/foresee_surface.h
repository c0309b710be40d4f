// A scheme beyond the thesis's PID: what lasts is foreseen from means over many cells, so that an interval's
// own roughness, which nothing foretells, is answered once and not again.
#pragma once

#include <array>

#include "core/control/surface/surface_memory.h"

namespace firn::control {

inline constexpr int kZoneBands = 5;
inline constexpr int kZones = 2 * 2 * kZoneBands;

/// Zone of each cell of a footprint, -1 beyond it: its material, whether the nearest border of that is one to
/// the other material or to what is bare, and in which band of `band_mm` the distance between the centres of
/// the cell and of the nearest cell beyond the border lies; the last band has no end.
Grid<std::int8_t> zones(const Grid<std::uint8_t>& material, double band_mm);

/// Mean over the finite cells of a square of `side_mm` about each finite cell; NaN where the cell is not
/// finite.
HeightMap square_mean(const HeightMap& values, double side_mm);

/// The surface obeys e_{k+1} = e_k - u'_k - d_k (5.16), u' being what was executed. D is the d that is
/// foreseen and v_k = e_{k-1} - u'_{k-1} - e_k - D_{k-1} what was not:
///   D = M[material] + Z[zone] + W(x, y)
///   M += phi S + flow_gain m, S = phi S + beta flow_gain m, m = mean of v over the material      valves that
///   drift Z += zone_gain * mean over the zone of what M leaves of v         edges that lack the same again
///   and again W += wide_gain * mean over squares of wide_mm of what Z leaves    a fixed pattern U_k = K_p (n
///   + narrow_gain (e_k - n)) - D, n = mean of e_k over squares of narrow_mm
/// Of the first map's means over a material 0.3 counts, and W stays 0: it holds the table's own shape, which
/// does not last. A map of the bare table (layer 0) before it is answered and teaches nothing, but Z starts
/// at what borders lack (0.05 intervals, half of it in the band behind): the rest of the first interval's
/// error is then the valves', and its map counts whole, with beta = 1.2 instead of 0.4. Zones belong to the
/// footprint, W to the place: it is resampled onto the new grid.
class ForeseeSurface final : public SurfaceScheduler {
 public:
  explicit ForeseeSurface(const SurfaceOptions& options) : SurfaceScheduler(options) {}
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
