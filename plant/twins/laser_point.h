// LaserPointTwin simulates the Keyence LK-G3001P with its LK-G32 head (docs/devices/laser_point.md): programs
// with settings, one reading on request, storage that samples while the robot's line is up, dump at 115200
// baud.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "plant/twins/ice_wires.h"
#include "plant/twins/lkg.h"
#include "plant/twins/twin.h"

namespace firn::plant {

class LaserPointTwin : public Twin {
 public:
  LaserPointTwin(const IceLaserParams& params, IceWires& wires);
  void take(std::span<const std::byte> bytes, std::int64_t now_us) override;
  void disconnected(std::int64_t) override { line_.clear(); }
  std::int64_t next_device_us() const override { return kNever; }
  void device_event(std::int64_t) override {}
  void reboot(std::int64_t now_us) override;
  void trip(std::int64_t now_us, std::int64_t code) override;  ///< 1 no values, 2 values stick
  void io(Archive& a) override;

  void signal(std::int64_t t_us, bool up);

 private:
  struct Program {
    std::int32_t sampling = 4, averaging = 2, material = 0, cycle = 4, most = 65536, offset = 0;
  };
  struct State {
    std::uint8_t communication = 0, storing = 0;
    std::int32_t selected = 0;
    std::int64_t busy_until_us = 0;
    std::array<Program, 8> programs{};
  };
  std::string execute(std::string_view command, std::int64_t now_us);
  bool set(std::string_view command);
  std::string setting(std::string_view identifier) const;  ///< empty: it has none
  LaserSettings settings() const;
  double window_s() const;  ///< over which a value is averaged
  double period_s() const;
  void close_storage(std::int64_t now_us);

  IceLaserParams params_;
  IceWires& wires_;
  State state_;
  std::string line_;
  std::vector<float> stored_;
};

}  // namespace firn::plant
