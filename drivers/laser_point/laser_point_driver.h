// LaserPointDriver is the interface of all kinds of point lasers: a series of distances along a path, or one
// now.
#pragma once

#include <cstdint>
#include <tuple>
#include <vector>

#include "drivers/laser_point/laser_point_config.h"
#include "drivers/link/driver.h"

namespace firn::drivers {

/// The values that the instrument stored, or one reading.
struct Samples {
  std::int32_t material = 0;
  std::int32_t expected = 0;  ///< asked for; 1 = a single reading
  std::int32_t damaged = 0;   ///< of the values, for a reason that the instrument does not give
  double period_s = 0.0;
  std::vector<float> z_mm;  ///< from the reference distance, up positive; NaN = no value
};

struct LaserPointOptions : LaserPointConfig {
  double host_latency_s = 0.0;  ///< see Dialect::allow_host_latency
};

class LaserPointDriver : public Driver {
 public:
  using Options = LaserPointOptions;
  using Measurements = std::tuple<Samples>;

  /// Settings of the material, if others are in force, then an empty storage that waits for the signal. Ready
  /// when armed. Refused: more samples than the storage holds, a period that the instrument has not.
  virtual void arm(int material, int samples, double period_s, std::int64_t now_us, Effects& fx) = 0;
  /// Ends the storage and reads it out: Samples, then Result{kDone} with counted = values. Also after a lost
  /// link.
  virtual void collect(std::int64_t now_us, Effects& fx) = 0;
  /// One reading now: Samples of one value, then Result{kDone}.
  virtual void reading(std::int64_t now_us, Effects& fx) = 0;

 protected:
  explicit LaserPointDriver(const Dialect& dialect) : Driver(dialect) {}
};

}  // namespace firn::drivers
