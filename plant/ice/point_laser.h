// laser_reading_mm computes the reading of the point laser from the true surface under its spot. The
// instrument repeats to 0.05 um, is linear to 0.05 % of its range, loses more values on reflective ice at
// higher speeds [Barnett 2012, Table 2-3, 4.2.1, 5.2.1], and reads badly with the settings of the other
// material.
#pragma once

#include <cstdint>

#include "plant/ice/arm.h"
#include "plant/ice/bed.h"

namespace firn::plant {

/// The surface for which the controller's settings are made.
enum class LaserSettings : std::uint8_t { kOther = 0, kIce = 1, kScaffold = 2 };

struct LaserKey {
  std::uint64_t seed = 0;
  std::uint32_t storage = 0;  ///< number of storages begun before
  std::uint32_t sample = 0;
};

/// Returns the height of the surface above the laser's tool point [mm], + = nearer; NaN = no value,
/// +-infinity = out of range.
double laser_reading_mm(const IceLaserParams& params, const Bed& bed, const IceTool& tool,
                        const ArmPose& pose, LaserSettings settings, const LaserKey& key);

}  // namespace firn::plant
