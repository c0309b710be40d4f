// ThermometerTwin simulates the thermometer of the bed (docs/devices/thermometer.md).
#pragma once

#include <string>

#include "plant/twins/ice_wires.h"
#include "plant/twins/twin.h"

namespace firn::plant {

class ThermometerTwin final : public Twin {
 public:
  explicit ThermometerTwin(IceWires& wires)
      : Twin(Port::kThermometer, TwinLink(10.0e6 / 9600.0, 2000)), wires_(wires) {}
  void take(std::span<const std::byte> bytes, std::int64_t now_us) override;
  void disconnected(std::int64_t) override { line_.clear(); }
  std::int64_t next_device_us() const override { return kNever; }
  void device_event(std::int64_t) override {}
  void reboot(std::int64_t now_us) override;
  /// 1 opens the probe, 0 closes it
  void trip(std::int64_t, std::int64_t code) override { open_ = code == 1; }
  void io(Archive& a) override { a.all(boot_count_, open_, line_, link_); }

 private:
  IceWires& wires_;
  bool open_ = false;
  std::string line_;
};

}  // namespace firn::plant
