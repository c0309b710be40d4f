// IceRig holds the five drivers of the path printer wired to the simulated world.
#pragma once

#include "drivers/heater/heater.h"
#include "drivers/laser_point/laser_point.h"
#include "drivers/robot/robot.h"
#include "drivers/valve/valve.h"
#include "plant/world/ice_lab.h"
#include "tests/drivers/port_rig.h"

namespace firn::drivers::test {

class IceRig : public PortRig {
 public:
  explicit IceRig(const plant::IceWorldConfig& ice = plant::IceWorldConfig{}, std::uint64_t seed = 1,
                  const RobotOptions& robot_options = RobotOptions{});

  void start();  ///< connects everything, waits until all are SAFE, homes the robot
  Result command(std::string_view port, const Act& f, double limit_s = 300);
  void fault(std::string_view port, plant::FaultKind kind, std::int64_t count = 1, std::int64_t delay_us = 0);

  Robot robot;
  Valve valve_a, valve_b;
  LaserPoint laser;
  Heater heater;
};

}  // namespace firn::drivers::test
