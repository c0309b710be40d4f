// StillArm is an arm for V+ programs that reaches every place at once; it counts its orders.
#pragma once

#include <vector>

#include "plant/twins/vplus/machine.h"

namespace firn::plant::vplus {

struct StillArm : RobotPort {
  std::vector<int> signalled;
  std::vector<Motion> motions;
  int calibrations = 0, brakes = 0;
  bool has_power = true;

  void signals(std::span<const int> numbers) override {
    signalled.insert(signalled.end(), numbers.begin(), numbers.end());
  }
  void power(bool on) override { has_power = on; }
  bool powered() const override { return has_power; }
  int calibrate() override {
    ++calibrations;
    return 0;
  }
  bool calibrating() const override { return false; }
  int state(int number) const override { return number == 1 ? 7 : 0; }
  PrecisionPoint here() const override { return motions.empty() ? PrecisionPoint{} : motions.back().to; }
  PrecisionPoint destination() const override { return here(); }
  int give(const Motion& motion) override {
    motions.push_back(motion);
    return 0;
  }
  bool waiting() const override { return false; }
  bool moving() const override { return false; }
  void brake() override { ++brakes; }
};

/// Executes a machine until world time `until_us`, or until no task runs.
inline void run_until(Machine& machine, std::int64_t until_us) {
  while (machine.next_us() <= until_us) machine.slice(machine.next_us());
  machine.happened(until_us);
}

}  // namespace firn::plant::vplus
