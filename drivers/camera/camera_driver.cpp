#include "drivers/camera/camera_driver.h"

#include <cstdio>

namespace firn::drivers {
namespace {

std::string outside(const char* what, double value, double low, double high, const char* unit) {
  if (value >= low && value <= high) return {};  // false for NaN
  char text[120];
  std::snprintf(text, sizeof text, "%s of %g %s is outside [%g, %g]", what, value, unit, low, high);
  return text;
}

}  // namespace

std::string CameraDriver::refusal_of(const Sweep& s, bool pictures) {
  if (pictures && (s.frames < 1 || s.frames > kMaxFrames))
    return "a sweep of " + std::to_string(s.frames) + " pictures is outside [1, " +
           std::to_string(kMaxFrames) + "]";
  const double last_us = pictures ? s.delay_of(s.frames - 1) : s.delay_us;
  for (const std::string& why : {outside("a strobe delay", s.delay_us, 0.0, kMaxDelay_us, "us"),
                                 outside("a strobe delay", last_us, 0.0, kMaxDelay_us, "us"),
                                 outside("an exposure", s.exposure_us, 0.0, kMaxExposure_us, "us"),
                                 outside("a gain", s.gain_db, -kMaxGain_db, kMaxGain_db, "dB")})
    if (!why.empty()) return why;
  return {};
}

}  // namespace firn::drivers
