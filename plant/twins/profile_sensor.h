// ProfileSensor is a simulated instrument that measures the surface at each trigger pulse, of any kind.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>

#include "core/grid/grid.h"
#include "plant/config/world_config.h"
#include "plant/twins/twin.h"

namespace firn::plant {

class ProfileSensor : public Twin {
 public:
  using Twin::Twin;
  /// Takes the sensor's readings at a trigger pulse [mm], NaN = no reading.
  virtual void trigger(std::int64_t t_us, std::int32_t encoder_counts, std::span<const double> z_mm) = 0;
  virtual std::uint32_t triggers() const = 0;
  /// A pulse makes it send bytes without being asked.
  virtual bool speaks_at_pulses() const { return false; }
};

/// Returns the height under the spot now [mm]; NaN = no reading.
using Look = std::function<double(std::int64_t t_us)>;

/// Returns the instrument of `params` over the grid. @param look for one that a person may ask between pulses
std::unique_ptr<ProfileSensor> make_profile_sensor(const GridSpec& grid, const ProfilerParams& params,
                                                   Look look);

}  // namespace firn::plant
