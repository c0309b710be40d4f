// measure_profile computes a reading of the profile sensor: a line across x at one y, seen through a laser
// spot, with noise and drop-outs.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "plant/config/world_config.h"
#include "plant/inkjet/field.h"

namespace firn::plant {

/// Identifies one measurement for the keyed random numbers.
struct ProfileKey {
  std::uint64_t seed = 0;
  std::uint32_t layer = 0;    ///< finished layers
  std::uint32_t trigger = 0;  ///< trigger number since the last exposure
};

/// Computes z_mm[n] = surface at (x0_mm + n dx_mm, y_mm) averaged over the spot, plus noise; NaN where the
/// sensor has no reading, with probability floor + per_slope x max(0, |dz/dx| - slope_from). The faults of
/// SensorOptions are in it: scale and tilt of the surface, correlated noise, ghosts beside edges. Beside the
/// field lies the substrate, z = 0. A field of one fine cell per pitch is seen as steps, a finer one as
/// piecewise linear.
void measure_profile(const Field& field, const SensorParams& params, ProfileKey key, double y_mm,
                     double x0_mm, double dx_mm, std::span<double> z_mm);

}  // namespace firn::plant
