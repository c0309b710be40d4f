// HeaterDriver is the interface of all kinds of heaters: an end effector's three, or a platen's one.
// HeaterWatch judges their readings (interlock 10).
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <tuple>

#include "drivers/heater/heater_config.h"
#include "drivers/link/driver.h"

namespace firn::drivers {

struct HeaterOptions : HeaterConfig {
  double min_rise_degC = 2.0;
  double host_latency_s = 0.0;  ///< see Dialect::allow_host_latency
};

/// Causes in Temperatures::fault and temperature_t.
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

/// A channel that has failed, as a fault tells it.
struct HeaterFailure {
  Severity severity = Severity::kStop;
  std::string text;
};

class HeaterDriver : public Driver {
 public:
  using Options = HeaterOptions;
  using Measurements = std::tuple<Temperatures>;
  static constexpr int kTip = 0, kWindow = 1, kConduit = 2;  ///< heaters (a), (b), (c)

  /// Set points [degC]; at or below -50 = off. They are sent again after a lost link. Refused above
  /// high_degC. Done when the controllers have confirmed them. A channel that has failed stays off; a new
  /// command judges it anew.
  virtual void set(const std::array<double, 3>& celsius, std::int64_t now_us, Effects& fx) = 0;
  /// The valves are kept from freezing: (a) or (b) is well. Of a platen: it is well.
  bool keeps_warm() const;

 protected:
  /// @throws std::invalid_argument naming the setting, its value and its range
  HeaterDriver(const Dialect& dialect, HeaterOptions config);

  bool has_platen() const { return config_.platen_degC > kHeaterOff_degC; }
  /// Nothing is connected to the channels beside the platen's.
  bool watched(std::size_t channel) const { return channel == kTip || !has_platen(); }
  /// Returns why these set points are not taken; empty: they are.
  std::string refusal_of(const std::array<double, 3>& celsius) const;
  /// Takes them over, and judges every channel anew.
  void take_set_points(const std::array<double, 3>& celsius);
  /// Returns the channels that have failed just now.
  std::array<bool, 3> judge(const Temperatures& read, std::int64_t now_us);
  HeaterFailure failure_of(int channel) const;
  bool heats(std::size_t channel) const;  ///< its set point is to be in force

  HeaterOptions config_;
  std::array<double, 3> set_celsius_{};
  std::array<HeaterWatch, 3> watch_;
  std::array<TemperatureFault, 3> fault_{};
};

}  // namespace firn::drivers
