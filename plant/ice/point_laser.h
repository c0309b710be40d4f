// What the point laser reads: true surface under its spot, seen by an instrument that repeats to 0.05 um, is
// straight to 0.05 % of its range, loses values on reflective ice the more the faster it goes [Barnett 2012,
// Table 2-3, 4.2.1, 5.2.1], and reads badly with the settings of the other material.
#pragma once

#include <cstdint>

#include "plant/ice/arm.h"
#include "plant/ice/bed.h"

namespace firn::plant {

/// Which surface the controller's settings are made for.
enum class LaserSettings : std::uint8_t { kOther = 0, kIce = 1, kScaffold = 2 };

struct LaserKey {
  std::uint64_t seed = 0;
  std::uint32_t storage = 0;  ///< how many storages were begun before
  std::uint32_t sample = 0;
};

/// Height of the surface above the laser's tool point [mm], + = nearer; NaN = no value, +-infinity = out of
/// range.
double laser_reading_mm(const IceLaserParams& params, const Bed& bed, const IceTool& tool,
                        const ArmPose& pose, LaserSettings settings, const LaserKey& key);

}  // namespace firn::plant
