// HeaterTwin simulates the box that reads the three thermostats (docs/devices/heater.md), of an end effector
// or a platen. The thermostats themselves are in plant/ice/heat.h.
#pragma once

#include <string>
#include <string_view>

#include "plant/ice/heat.h"
#include "plant/twins/twin.h"

namespace firn::plant {

/// The wires of the box.
class HeaterWires {
 public:
  virtual ~HeaterWires() = default;
  virtual Heat& heat() = 0;
  virtual void note(std::int64_t t_us, Port port, DeviceEvent event, std::int64_t value) = 0;
};

/// Faults of the heaters themselves, whatever box commands them: codes of trip(), 1..3 heater dead, 4..6
/// thermocouple open, 7..9 relay stuck on, 10..12 reading frozen, 0 no fault.
void trip_heaters(Heat& heat, std::int64_t now_us, std::int64_t code);

class HeaterTwin : public Twin {
 public:
  /// @param highest_degC the box takes no set point above it
  explicit HeaterTwin(HeaterWires& wires, double highest_degC = 45.0)
      : Twin(Port::kHeater, TwinLink(10.0e6 / 9600.0, 2000)), wires_(wires), highest_degC_(highest_degC) {}
  void take(std::span<const std::byte> bytes, std::int64_t now_us) override;
  void disconnected(std::int64_t) override { line_.clear(); }
  std::int64_t next_device_us() const override { return kNever; }
  void device_event(std::int64_t) override {}
  void reboot(std::int64_t now_us) override;
  void trip(std::int64_t now_us, std::int64_t code) override { trip_heaters(wires_.heat(), now_us, code); }
  void io(Archive& a) override { a.all(boot_count_, line_, link_); }

 private:
  std::string execute(std::string_view command, std::int64_t now_us);

  HeaterWires& wires_;
  double highest_degC_;
  std::string line_;
};

}  // namespace firn::plant
