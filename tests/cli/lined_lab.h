// LinedLab is an ice lab whose instruments stand behind serial lines and a TCP port, with the block on its
// table and a cup on a balance: what `firn calibrate` finds there by the clock is held against simulated
// time.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "print/device/simulated_instruments.h"
#include "tests/cli/run_firn.h"
#include "tests/live/port_bridge.h"

namespace firn::test {

class LinedLab {
 public:
  /// The simulated surface lies about (x, y), part frame. @param keys of the lab, besides
  LinedLab(const std::vector<std::string>& keys, double x_mm, double y_mm, double width_mm, double depth_mm);

  /// Runs `firn calibrate KIND --json`, on the lines or in simulated time.
  Said calibrate(const std::string& what, bool real, const std::vector<std::string>& more);

 private:
  std::vector<std::string> keys_;
  SimulatedInstruments world_;
  PortBridge robot_{PortBridge::Kind::kTcp, world_.address("robot").place};
  PortBridge valve_a_{PortBridge::Kind::kSerial, world_.address("valve_a").place};
  PortBridge valve_b_{PortBridge::Kind::kSerial, world_.address("valve_b").place};
  PortBridge laser_{PortBridge::Kind::kSerial, world_.address("laser_point").place};
  PortBridge heater_{PortBridge::Kind::kSerial, world_.address("heater").place};
};

/// A value that was found twice, with the sum of both 95 % half widths.
struct FoundTwice {
  std::string key;
  double real = 0.0, simulated = 0.0, half_95 = 0.0;
  bool alike() const { return std::abs(real - simulated) <= half_95; }
};

/// @param real, simulated output of `firn calibrate --json`
std::vector<FoundTwice> found_twice(const std::string& real, const std::string& simulated);

}  // namespace firn::test
