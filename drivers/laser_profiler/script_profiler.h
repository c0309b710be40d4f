// ScriptProfiler drives a profiler by a class in Python: arm(rows), then rows(), asked again and again, which
// returns the new profiles: {"row": [...], "y_mm": [...], "x0_mm": 0.0, "dx_mm": 0.05, "z_mm": (rows,
// points)}, and end(). A row is a trigger since arm(), from 0; y_mm the stage's Y at it.
#pragma once

#include <cstdint>
#include <string>

#include "drivers/laser_profiler/profiler_driver.h"
#include "drivers/script/script_driver.h"

namespace firn::drivers {

class ScriptProfiler final : public ScriptDriver<ProfilerDriver> {
 public:
  /// @param counts_per_mm of the stage, in which its Y is told on
  /// @throws std::invalid_argument naming the setting, its value and its range
  ScriptProfiler(ScriptOptions script, LaserProfilerOptions config, double counts_per_mm);

  void arm(int rows, std::int64_t now_us, Effects& fx) override;
  void end(std::int64_t now_us, Effects& fx) override;

 private:
  enum Tag : std::uint16_t { kArm = kFirstTag, kRows, kEnd };

  void returned(std::uint16_t tag, const Line& line, std::int64_t now_us, Effects& fx) override;
  void became_safe(std::int64_t now_us, Effects& fx) override;
  bool work(std::int64_t now_us, Effects& fx) override;
  std::int64_t work_wake_us() const override { return scanning_ && ready() && !waits() ? ask_us_ : 0; }
  void program_lost(Effects& fx) override { scan_over(fx); }
  Result broken_off(Outcome outcome, std::int32_t code, std::string text) override;
  /// Returns why these are no profiles; empty: they were passed on.
  std::string take(const Line& line, Effects& fx);
  void scan_over(Effects& fx);

  LaserProfilerOptions config_;
  double counts_per_mm_;
  int rows_ = 0, received_ = 0;
  bool scanning_ = false;
  std::int64_t ask_us_ = 0;
};

}  // namespace firn::drivers
