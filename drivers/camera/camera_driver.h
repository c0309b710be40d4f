// CameraDriver is the interface of all kinds of cameras: sweeps of pictures at strobe delays.
#pragma once

#include <cstdint>
#include <string>
#include <tuple>

#include "drivers/camera/camera_config.h"
#include "drivers/camera/picture.h"
#include "drivers/link/driver.h"

namespace firn::drivers {

struct CameraOptions : CameraConfig {
  double host_latency_s = 0.0;  ///< see Dialect::allow_host_latency
};

/// Pictures of one sweep: the k-th at the strobe delay delay_us + k step_us.
struct Sweep {
  std::int32_t frames = 1;
  double delay_us = 0.0, step_us = 0.0;
  double exposure_us = 0.0;  ///< 0 = the configured one
  double gain_db = 0.0;
  double delay_of(std::int32_t k) const { return delay_us + k * step_us; }
};

/// One picture of the sweep in progress.
struct CameraShot {
  std::int32_t index = 0;  ///< 0-based
  Sweep sweep;             ///< with the exposure that was set
  Picture picture;
};

class CameraDriver : public Driver {
 public:
  using Options = CameraOptions;
  using Measurements = std::tuple<CameraShot>;
  /// Delays, exposures and gains beyond these are refused.
  static constexpr double kMaxDelay_us = 2e9, kMaxExposure_us = 1e7, kMaxGain_db = 100.0;
  static constexpr std::int32_t kMaxFrames = 1000;

  /// CameraShot for each picture, then Result{kDone} with counted = pictures.
  virtual void sweep(const Sweep& sweep, std::int64_t now_us, Effects& fx) = 0;
  /// Sets exposure, gain and delay: Result{kDone}.
  virtual void set_up(const Sweep& sweep, std::int64_t now_us, Effects& fx) = 0;

 protected:
  explicit CameraDriver(const Dialect& dialect) : Driver(dialect) {}

  /// Returns why no camera takes these; empty: one may. @param pictures the sweep is to be taken
  static std::string refusal_of(const Sweep& sweep, bool pictures);
};

}  // namespace firn::drivers
