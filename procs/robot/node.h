// RobotNode connects the robot to the bus: ROBOT_COMMAND, TRAJECTORY, ENABLE, SAFE_STOP, instrument ->
// ANSWER_ROBOT, STATE_ROBOT, FAULT_ROBOT.
#pragma once

#include <array>
#include <memory>
#include <string>

#include "config/experiment.h"
#include "config/machine.h"
#include "drivers/robot/robot.h"
#include "firn/robot_command_t.hpp"
#include "firn/trajectory_t.hpp"
#include "runtime/driver_node.h"

namespace firn {

/// Adapter of drivers/robot. Trajectories are sent to the robot on arrival, ahead of the commands that run
/// them. A move's pose is that of a tool in the part's frame; the arm's kinematics turn it into joints here.
/// ANSWER_ROBOT of a run: counted = measured, expected = planned microseconds; unknown_from, unknown_to = of
/// the path.
class RobotNode final : public DriverNode<RobotNode, drivers::Robot, drivers::Effects> {
 public:
  RobotNode(const Experiment& experiment, const Machine& machine);

  using DriverNode::on;
  void on(const trajectory_t&, Time now, Outbox&);
  void on(const robot_command_t&, Time now, Outbox&);

 private:
  drivers::fvp::Joints joints_of(const robot_command_t& c) const;

  std::unique_ptr<motion::Arm> arm_;
  motion::ArmConfiguration configuration_;
  std::array<motion::Tool, 4> tools_;  // by robot_command_t.tool
  std::array<double, 3> origin_mm_;    // of the part in the base frame
};

/// Inputs: "machine"; without it the Cobra 600 of the thesis.
std::unique_ptr<Node> make_robot(const std::string& config_toml, const Blobs& blobs);

}  // namespace firn
