// CameraConfig holds the settings of the camera, with range and meaning of each.
#pragma once

#include "core/options/on_off.h"
#include "core/options/option.h"

namespace firn::drivers {

struct CameraConfig {
  OnOff use = OnOff::kOff;
  double exposure_us = 100.0;
  double gain_db = 0.0;
  double preview_s = 0.5;    ///< between two previews
  double poll_idle_s = 2.0;  ///< between questions to a camera that nobody uses
  double picture_s = 2.0;    ///< longest wait for a picture beyond its exposure
};
inline constexpr OptionTable kCameraConfig{
    Option{"use", &CameraConfig::use, "", Range{}, "on: the lab has a camera"},
    Option{"exposure_us", &CameraConfig::exposure_us, "us", above(0, 1e7), "of a picture"},
    Option{"gain_db", &CameraConfig::gain_db, "dB", within(-100, 100), "of the sensor"},
    Option{"preview_s", &CameraConfig::preview_s, "s", above(0, 60), "least time between two CAMERA_PREVIEW"},
    Option{"poll_idle_s", &CameraConfig::poll_idle_s, "s", above(0, 60),
           "between questions to a camera that takes no pictures"},
    Option{"picture_s", &CameraConfig::picture_s, "s", above(0, 60),
           "longest wait for a picture, beyond its exposure"},
};

}  // namespace firn::drivers
