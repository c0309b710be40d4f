// Heater controls an end effector's three heaters or a platen's one: set points, temperatures once a second,
// and interlock 10. Heater (b) alone keeps the valves from freezing when (a) fails [Barnett 2012, 2.3.3];
// without both, or without the platen's, nothing may be deposited.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "drivers/heater/heater_config.h"
#include "drivers/heater/thermostat.h"
#include "drivers/link/driver.h"

namespace firn::drivers {

struct HeaterOptions : HeaterConfig {
  double min_rise_degC = 2.0;
  double host_latency_s = 0.0;  ///< see Dialect::allow_host_latency
};

/// Of Temperatures::fault and temperature_t.
enum TemperatureFault : std::int8_t {
  kHeaterWell,
  kOpenThermocouple,
  kNoRise,
  kTooHot,
  kTooCold,
  kFrozenReading
};
const char* name(TemperatureFault fault);

/// Judges one channel's readings. Once found, a fault stays until reset(): a heater that has failed is not
/// trusted again.
class HeaterWatch {
 public:
  explicit HeaterWatch(const HeaterOptions& config) : config_(config) {}
  TemperatureFault judge(double celsius, double set_celsius, bool heating, std::int64_t now_us);
  void reset();

 private:
  HeaterOptions config_;
  TemperatureFault fault_ = kHeaterWell;
  bool was_warm_ = false;
  int open_ = 0;  // readings in a row
  std::int64_t on_since_us_ = 0;
  double on_from_degC_ = 0.0;
  std::int64_t same_since_us_ = 0, worked_us_ = 0, last_us_ = 0;
  double same_degC_ = 0.0;
};

/// The temperatures of the three channels and their faults.
struct Temperatures {
  std::array<double, 3> celsius{};  ///< NaN = open thermocouple
  std::array<double, 3> set_celsius{};
  std::array<std::int8_t, 3> fault{};  ///< TemperatureFault
  std::array<bool, 3> heating{};
};

class Heater final : public Driver {
 public:
  using Measurements = std::tuple<Temperatures>;
  static constexpr int kTip = 0, kWindow = 1, kConduit = 2;  ///< heaters (a), (b), (c)

  /// @throws std::invalid_argument naming the setting, its value and its range
  explicit Heater(HeaterOptions config);

  /// Set points [degC]; at or below -50 = off. They are sent again after a lost link. Refused above
  /// high_degC. Done when the controllers have confirmed them. A channel that has failed stays off; a new
  /// command judges it anew.
  void set(const std::array<double, 3>& celsius, std::int64_t now_us, Effects& fx);

  bool busy() const override { return setting_; }
  /// The valves are kept from freezing: (a) or (b) is well. Of a platen: it is well.
  bool keeps_warm() const;

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

  bool has_platen() const { return config_.platen_degC > kHeaterOff_degC; }
  /// Nothing is connected to the channels beside the platen's.
  bool watched(std::size_t channel) const { return channel == kTip || !has_platen(); }
  void push_set_points();
  void judge(const thermostat::Reading& reading, std::int64_t now_us, Effects& fx);
  void tell(int channel, Effects& fx);
  void finish(Outcome outcome, std::int32_t code, std::string text, Effects& fx);

  HeaterOptions config_;
  thermostat::ThermostatDialect dialect_;
  Phase phase_ = Phase::kDown;
  bool setting_ = false;
  bool commanded_ = false;  // there were set points
  std::array<double, 3> set_celsius_{};
  std::array<HeaterWatch, 3> watch_;
  std::array<TemperatureFault, 3> fault_{};
  std::int64_t next_read_us_ = 0;
};

}  // namespace firn::drivers
