// ScriptPoint drives a point laser by a class in Python: reading(), the distance now, and for series
// arm(material, samples, period_s) and collect(), which returns the samples; a value that is not there is NaN
// or None. Heights in mm from the reference distance, up positive.
#pragma once

#include <cstdint>

#include "drivers/laser_point/laser_point_driver.h"
#include "drivers/script/script_driver.h"

namespace firn::drivers {

class ScriptPoint final : public ScriptDriver<LaserPointDriver> {
 public:
  /// @throws std::invalid_argument naming the setting, its value and its range
  ScriptPoint(ScriptOptions script, LaserPointOptions config);

  void arm(int material, int samples, double period_s, std::int64_t now_us, Effects& fx) override;
  void collect(std::int64_t now_us, Effects& fx) override;
  void reading(std::int64_t now_us, Effects& fx) override;

 private:
  enum Tag : std::uint16_t { kArm = kFirstTag, kCollect, kReading };

  void returned(std::uint16_t tag, const Line& line, std::int64_t now_us, Effects& fx) override;
  void became_safe(std::int64_t, Effects&) override {}
  bool lacks(const char* method, Effects& fx);

  LaserPointOptions config_;
  int material_ = 0, expected_ = 0;
  double period_s_ = 0.0;
};

}  // namespace firn::drivers
