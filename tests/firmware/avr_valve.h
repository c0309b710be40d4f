// AvrValve is a valve's box of the simulated world whose binary runs in simavr (avr_box.h). The edges of its
// hold output are nature's pulses.
//
// The box runs in steps of at most 0.4 ms of the world's time, so that a pulse is known before its drop
// leaves the nozzle 1.1 ms after its begin. While the host has no list armed and the line is silent its clock
// stands: the coil does not cool meanwhile, which errs towards closing.
#pragma once

#include <array>
#include <optional>

#include "plant/twins/fvb.h"
#include "plant/twins/ice_wires.h"
#include "plant/twins/valve_box.h"
#include "tests/firmware/avr_box.h"

namespace firn::test {

class AvrValve : public plant::ValveBox {
 public:
  AvrValve(const std::string& elf, int valve, const plant::IceValveParams& params, plant::IceWires& wires);
  void take(std::span<const std::byte> bytes, std::int64_t now_us) override;
  std::int64_t next_device_us() const override;
  void device_event(std::int64_t now_us) override;
  void reboot(std::int64_t now_us) override;
  void trip(std::int64_t now_us, std::int64_t code) override;
  /// Keeps the EEPROM alone: a box that is restored has lost its power.
  void io(plant::Archive& a) override;
  void signal(std::int64_t t_us) override;
  void disable(std::int64_t t_us) override;

 private:
  struct List {
    std::int64_t triggered_us = 0, first_us = 0, last_us = 0;
    std::uint32_t pulses = 0;
    double volume_mm3 = 0.0;
  };

  void start(std::int64_t now_us, std::vector<std::uint8_t> eeprom);
  double us_at(std::uint64_t cycle) const;
  std::uint64_t cycle_at(std::int64_t now_us) const;
  void wake(std::int64_t now_us);
  void run_until(std::int64_t now_us);
  void see_edges();
  void pulse(std::uint64_t opened, std::uint64_t closed);
  void hear_host();
  void hear_box(std::int64_t now_us);
  void settle(std::int64_t now_us);  ///< records a list that is over

  std::string elf_;
  int valve_;
  plant::IceValveParams params_;
  plant::IceWires& wires_;
  std::unique_ptr<AvrBox> box_;
  std::int64_t base_us_ = 0, ran_us_ = 0, stirred_us_ = 0, signalled_us_ = 0;
  std::uint64_t base_cycle_ = 0, opened_ = 0;
  bool awake_ = true, armed_ = false, counted_ = true;
  std::int64_t rises_us_ = plant::kNever, falls_us_ = plant::kNever, enables_us_ = plant::kNever;
  std::vector<std::byte> from_host_, from_box_;
  std::array<plant::fvb::Kind, 256> asked_{};  ///< by number of the request
  plant::fvb::Head head_;
  std::optional<List> list_;
  std::optional<plant::FiringEnd> over_;
};

}  // namespace firn::test
