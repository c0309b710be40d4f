// FirmwareValveTwin simulates a valve's microcontroller with its firmware itself (firmware/valve), built for
// the host. ValveTwin (valve.h) is written from FVB/1 alone; the two must answer alike.
#pragma once

#include "firmware/valve/valve.h"
#include "plant/twins/ice_wires.h"
#include "plant/twins/valve_box.h"

namespace firn::plant {

class FirmwareValveTwin : public ValveBox {
 public:
  /// @param valve 0 water, 1 SME
  /// @param host_scale as WorldConfig's
  FirmwareValveTwin(int valve, const IceValveParams& params, double host_scale, IceWires& wires);
  void take(std::span<const std::byte> bytes, std::int64_t now_us) override;
  std::int64_t next_device_us() const override;
  void device_event(std::int64_t now_us) override;
  void reboot(std::int64_t now_us) override;
  void trip(std::int64_t now_us, std::int64_t code) override;  ///< as ValveTwin's
  void io(Archive& a) override;
  void signal(std::int64_t t_us) override;
  void disable(std::int64_t t_us) override;

 private:
  void boot(std::uint8_t reset_cause, std::int64_t now_us);
  std::int64_t time_of(std::int64_t step) const;
  void run_until(std::int64_t now_us);
  void look(std::int64_t now_us);  ///< follows the lists that the firmware has begun or ended
  void begun(std::int64_t now_us);
  void ended(std::int64_t now_us);

  int valve_;
  IceValveParams params_;
  double host_scale_;
  IceWires& wires_;
  ::valve firmware_{};
  std::int64_t booted_us_ = 0, step_ = 0, trigger_at_us_ = kNever, triggered_us_ = 0;
  bool fires_ = false, never_arms_ = false, was_armed_ = false;
};

}  // namespace firn::plant
