// Heater controls an end effector's three heaters or a platen's one: set points, temperatures once a second,
// and interlock 10. Heater (b) alone keeps the valves from freezing when (a) fails [Barnett 2012, 2.3.3];
// without both, or without the platen's, nothing may be deposited.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "drivers/heater/heater_driver.h"
#include "drivers/heater/thermostat.h"

namespace firn::drivers {

class Heater final : public HeaterDriver {
 public:
  /// @throws std::invalid_argument naming the setting, its value and its range
  explicit Heater(HeaterOptions config);

  void set(const std::array<double, 3>& celsius, std::int64_t now_us, Effects& fx) override;

  bool busy() const override { return setting_; }

 private:
  enum class Phase : std::uint8_t { kDown, kIdentifying, kReady };
  enum Tag : std::uint16_t { kRead, kSet };

  void connected(std::int64_t now_us, Effects& fx) override;
  void reply(const Request& request, std::span<const std::byte> frame, std::int64_t now_us,
             Effects& fx) override;
  void failed(const Request& request, std::int64_t now_us, Effects& fx) override;
  void lost(std::int64_t now_us, Effects& fx) override;
  void stop(std::int64_t now_us, Effects& fx) override;
  bool idle(std::int64_t now_us, Effects& fx) override;
  std::int64_t device_wake_us() const override;
  bool stopping() const override { return false; }

  void push_set_points();
  void take(const thermostat::Reading& reading, std::int64_t now_us, Effects& fx);
  void tell(int channel, Effects& fx);
  void finish(Outcome outcome, std::int32_t code, std::string text, Effects& fx);

  thermostat::ThermostatDialect dialect_;
  Phase phase_ = Phase::kDown;
  bool setting_ = false;
  bool commanded_ = false;  // there were set points
  std::int64_t next_read_us_ = 0;
};

}  // namespace firn::drivers
