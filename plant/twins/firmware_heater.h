// FirmwareHeaterTwin simulates the heaters' box with its firmware itself (firmware/heater), built for the
// host. It reads nature's thermocouples through converters of 0.25 degC and switches nature's relays.
// HeaterTwin (heater.h) is written from the lines' page alone, and its thermostats are nature's; the two must
// answer alike.
#pragma once

#include <string>

#include "firmware/heater/heater.h"
#include "plant/twins/heater.h"

namespace firn::plant {

class FirmwareHeaterTwin : public Twin {
 public:
  explicit FirmwareHeaterTwin(HeaterWires& wires, double highest_degC = 45.0);
  void take(std::span<const std::byte> bytes, std::int64_t now_us) override;
  std::int64_t next_device_us() const override { return tick_us_; }
  void device_event(std::int64_t now_us) override;
  void reboot(std::int64_t now_us) override;
  void trip(std::int64_t now_us, std::int64_t code) override;  ///< as HeaterTwin's
  void io(Archive& a) override;

 private:
  void start();

  HeaterWires& wires_;
  std::int32_t highest_cdegC_;
  ::heater firmware_{};
  std::array<std::int32_t, HEATER_CHANNELS> kept_cdegC_{};  ///< the box's EEPROM
  std::int64_t tick_us_ = 0;
};

/// Returns the 32 bits that a MAX31855 sends for a thermocouple of this temperature; NaN: open.
std::uint32_t converted(double degC);

}  // namespace firn::plant
