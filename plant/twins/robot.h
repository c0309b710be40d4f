// RobotTwin simulates the robot's controller: the V+ program of docs/devices/robot.md (FVP/1) on a C40, its
// trajectory generator and its own watchdog. The true position of the arm is in plant/ice/arm.h.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "plant/twins/fvp.h"
#include "plant/twins/ice_wires.h"
#include "plant/twins/twin.h"

namespace firn::plant {

class RobotTwin : public Twin {
 public:
  /// @param host_scale as WorldConfig's
  RobotTwin(const IceArmParams& params, std::uint64_t seed, double host_scale, IceWires& wires);
  void take(std::span<const std::byte> bytes, std::int64_t now_us) override;
  void disconnected(std::int64_t now_us) override;  ///< by the host: whatever moves is braked
  std::int64_t next_device_us() const override;
  void device_event(std::int64_t now_us) override;
  bool device_event_replies() const override { return true; }  ///< events come by themselves
  void reboot(std::int64_t now_us) override;
  void trip(std::int64_t now_us,
            std::int64_t code) override;  ///< 1 emergency stop pressed, 2 motion error, 3 power does not come
  void io(Archive& a) override;

 private:
  enum class Motion : std::uint8_t { kNone, kMove, kPath, kBraking };
  struct Slot {
    std::int32_t id = 0;
    std::uint32_t wanted = 0;
    std::uint8_t verified = 0;
    std::vector<fvp::Point> points;
    void io(Archive& a) { a.all(id, wanted, verified, points); }
  };
  struct State {
    std::uint8_t power = 0, calibrated = 0, held = 0, fault = 0, estop = 0, pressed = 0, powerless = 0;
    std::uint8_t last_done = 0, state2 = 0;
    Motion motion = Motion::kNone;
    std::int32_t speed = 100, error = 0, running = 0, at = 0, last = 0, last_ms = 0, mask = 0,
                 wanted_mask = 0;
    std::int32_t loading = -1;  ///< slot between BEGIN and END
    std::int64_t boot_until_us = 0, power_at_us = kNever, calibrated_at_us = kNever, seen_us = 0;
    std::int64_t signal_us = kNever, begins_us = 0, ends_us = kNever, event = 0, paths = 0;
    std::int64_t last_seq = 0;
  };

  void line(std::string_view text, std::int64_t now_us);
  std::string execute(std::string_view text, std::int64_t now_us);
  std::string path(Words& words, std::int64_t now_us);
  std::string add_points(Words& words);
  std::string run(std::int32_t id, int mask, std::int64_t now_us);
  std::string move(const Joints& to, double percent, std::int64_t now_us);
  std::string status() const;
  void event(std::string_view kind, std::int64_t now_us);
  fvp::State shown() const;
  std::string refused_here() const;  ///< by its state
  void set_signals(int mask, std::int64_t now_us);
  void halt(std::int64_t now_us, double within_s, DeviceEvent why);
  void finish(std::int64_t now_us, bool done);
  void fail(int error, std::int64_t now_us, DeviceEvent why);
  Slot* find(std::int32_t id);

  IceArmParams params_;
  std::uint64_t seed_;
  std::int64_t watchdog_us_;
  IceWires& wires_;
  State state_;
  std::array<Slot, fvp::kSlots> slots_;
  std::string line_, reply_;
};

}  // namespace firn::plant
