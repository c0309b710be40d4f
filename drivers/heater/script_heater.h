// ScriptHeater drives heaters by a class in Python: set(celsius), three set points, NaN = off, and read(),
// which returns celsius and heating, three of each. Interlock 10 is judged here. safe() leaves the heat on:
// freezing destroys the valves.
#pragma once

#include <array>
#include <cstdint>

#include "drivers/heater/heater_driver.h"
#include "drivers/script/script_driver.h"

namespace firn::drivers {

class ScriptHeater final : public ScriptDriver<HeaterDriver> {
 public:
  /// @throws std::invalid_argument naming the setting, its value and its range
  ScriptHeater(ScriptOptions script, HeaterOptions config);

  void set(const std::array<double, 3>& celsius, std::int64_t now_us, Effects& fx) override;

 private:
  enum Tag : std::uint16_t { kSet = kFirstTag, kRead };

  void returned(std::uint16_t tag, const Line& line, std::int64_t now_us, Effects& fx) override;
  void became_safe(std::int64_t now_us, Effects& fx) override;
  bool work(std::int64_t now_us, Effects& fx) override;
  std::int64_t work_wake_us() const override { return ready() && !waits() ? next_read_us_ : 0; }
  void take(const Line& line, std::int64_t now_us, Effects& fx);

  bool commanded_ = false;  // there were set points: they are sent again after a lost link
  bool to_send_ = false;
  std::int64_t next_read_us_ = 0;
};

}  // namespace firn::drivers
