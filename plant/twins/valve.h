// ValveTwin simulates a valve's microcontroller (FVB/1, docs/devices/valve.md): one list of pulse times,
// fired at the robot's signal when it is armed. The liquid of a pulse is in plant/ice/line.h.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "plant/twins/fvb.h"
#include "plant/twins/ice_wires.h"
#include "plant/twins/valve_box.h"

namespace firn::plant {

class ValveTwin : public ValveBox {
 public:
  /// @param valve 0 water, 1 SME
  /// @param host_scale as WorldConfig's
  ValveTwin(int valve, const IceValveParams& params, double host_scale, IceWires& wires);
  void take(std::span<const std::byte> bytes, std::int64_t now_us) override;
  std::int64_t next_device_us() const override;
  void device_event(std::int64_t now_us) override;  ///< end of the list or of the wait, or the watchdog
  void reboot(std::int64_t now_us) override;
  void trip(std::int64_t now_us,
            std::int64_t code) override;  ///< 1 tank empty, 2 line blocked, 3 coil dead,
                                          ///< 4 disarmed at its panel, 5 ARM has no effect,
                                          ///< 6 stays open from its next pulse on
  void io(Archive& a) override;

  void signal(std::int64_t t_us) override;
  void disable(std::int64_t t_us) override;

 private:
  struct Device {
    fvb::State state = fvb::State::kIdle;
    std::uint8_t reset_cause = 0, last_seq = 0, known = 0;
    fvb::Head head;
    std::uint64_t fired = 0;
    std::int64_t triggered_us = 0, wait_until_us = kNever, ends_us = kNever, heard_us = 0;
  };
  void execute(const fvb::Intake& frame, std::int64_t now_us);
  fvb::Nak obey(const fvb::Intake& frame, std::int64_t now_us);  ///< kNone: acknowledged
  fvb::Nak begin(const fvb::Intake& frame);
  fvb::Nak add(const fvb::Intake& frame);
  void stop(std::int64_t now_us, FiringEnd why);

  int valve_;
  IceValveParams params_;
  std::int64_t silence_us_, pause_us_;
  IceWires& wires_;
  Device device_;
  std::vector<std::uint16_t> ticks_;
  std::int64_t heard_byte_us_ = 0;
  bool never_arms_ = false;
  std::vector<std::byte> buffer_;
  std::string reply_;
};

}  // namespace firn::plant
