// ScriptCamera drives a camera by a class in Python: picture(delay_us, exposure_us, gain_db) returns the grey
// levels, (height, width) numbers, or {"pixels": ..., "white": 4095, "age_s": 0.01}.
#pragma once

#include <cstdint>
#include <string>

#include "drivers/camera/camera_driver.h"
#include "drivers/script/script_driver.h"

namespace firn::drivers {

class ScriptCamera final : public ScriptDriver<CameraDriver> {
 public:
  /// @throws std::invalid_argument naming the setting, its value and its range
  ScriptCamera(ScriptOptions script, CameraOptions config);

  void sweep(const Sweep& sweep, std::int64_t now_us, Effects& fx) override;
  /// Kept for pictures whose sweep names no exposure: the class is told with each picture.
  void set_up(const Sweep& sweep, std::int64_t now_us, Effects& fx) override;

 private:
  enum Tag : std::uint16_t { kPicture = kFirstTag };

  bool takes(const Sweep& sweep, bool pictures, Effects& fx);
  void ask(std::int64_t now_us);
  void returned(std::uint16_t tag, const Line& line, std::int64_t now_us, Effects& fx) override;
  void became_safe(std::int64_t, Effects&) override {}
  Result broken_off(Outcome outcome, std::int32_t code, std::string text) override;

  CameraOptions config_;
  Sweep sweep_;
  std::int32_t taken_ = 0;
};

}  // namespace firn::drivers
