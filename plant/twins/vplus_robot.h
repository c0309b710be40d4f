// VplusRobotTwin simulates the robot's controller with the V+ text itself: the programs of
// drivers/robot/vplus run statement by statement in plant/twins/vplus and move the arm of plant/ice/arm.h.
// RobotTwin (robot.h) is written from the protocol alone; the two must answer alike.
#pragma once

#include <string>
#include <vector>

#include "plant/config/ice_config.h"
#include "plant/twins/ice_wires.h"
#include "plant/twins/twin.h"
#include "plant/twins/vplus/machine.h"

namespace firn::plant {

class VplusRobotTwin : public Twin, private vplus::RobotPort {
 public:
  /// @throws std::invalid_argument naming file and line of the program's text
  VplusRobotTwin(const IceArmParams& params, const IceRobotProgram& program, std::uint64_t seed,
                 IceWires& wires);
  void connected(std::int64_t now_us) override;
  void disconnected(std::int64_t now_us) override;
  void take(std::span<const std::byte> bytes, std::int64_t now_us) override;
  std::int64_t next_device_us() const override;
  void device_event(std::int64_t now_us) override;
  bool device_event_replies() const override { return true; }
  void reboot(std::int64_t now_us) override;
  /// As RobotTwin's: 1 emergency stop pressed, 2 motion error, 3 power does not come, 0 the fault ends.
  void trip(std::int64_t now_us, std::int64_t code) override;
  void io(Archive& a) override;

  const vplus::Machine& machine() const { return machine_; }
  std::int64_t late_segments() const {
    return state_.late;
  }  ///< of paths: begun after the one before had ended

 private:
  enum class Kind : std::uint8_t { kNone, kMove, kPath, kBraking };
  struct State {
    Kind kind = Kind::kNone, waiting = Kind::kNone;
    std::uint8_t power = 0, calibrated = 0, pressed = 0, powerless = 0, state2 = 0, slips = 0;
    std::int32_t mask = 0, ticks = 1;
    std::int64_t boot_until_us = 0, power_at_us = kNever, calibrated_at_us = kNever, ends_us = kNever;
    std::int64_t paths = 0, late = 0;
    double ends_s = 0.0;          ///< of the motion that has begun, world time
    double waiting_s = 0.0;       ///< how long the one that waits takes
    Joints from{}, to{}, next{};  ///< of the motion that has begun; end of the one that waits
    double percent = 0.0;         ///< of the one that waits
  };

  // vplus::RobotPort
  void signals(std::span<const int> numbers) override;
  void power(bool on) override;
  bool powered() const override { return state_.power != 0; }
  int calibrate() override;
  bool calibrating() const override { return state_.calibrated_at_us != kNever; }
  int state(int number) const override;
  vplus::PrecisionPoint here() const override;
  vplus::PrecisionPoint destination() const override;
  int give(const vplus::Motion& motion) override;
  bool waiting() const override { return state_.waiting != Kind::kNone; }
  bool moving() const override { return state_.kind != Kind::kNone; }
  void brake() override { halt(params_.brake_s, DeviceEvent::kRobotBraked); }

  void start();
  void begin(Kind kind, double start_s);
  std::vector<Joints> segment(const Joints& from, const Joints& to, double span_s) const;
  void ended();
  void halt(double within_s, DeviceEvent why);
  void flush();
  double clock() const { return 1.0 + params_.clock_ppm * 1e-6; }

  IceArmParams params_;
  std::uint64_t seed_;
  IceWires& wires_;
  vplus::Code code_;
  vplus::MachineOptions options_;
  vplus::Machine machine_;
  State state_;
  std::int64_t now_us_ = 0;
};

}  // namespace firn::plant
