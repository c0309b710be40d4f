#include "procs/robot/node.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "config/ice_lab.h"

namespace firn {
namespace {

constexpr double kRateSlack =
    1.02;  // of the machine's joint rates: a trajectory is certified between its samples
constexpr double kFullSpeed_mm_s =
    3770.0;  // J1 at 360 deg/s with the arm stretched: the speed of 100 percent

drivers::RobotOptions robot_config(const Experiment& e, const Machine& machine) {
  drivers::RobotOptions c;
  static_cast<RobotConfig&>(c) = e.robot;
  const std::unique_ptr<motion::Arm> arm = make_arm(machine);
  for (std::size_t j = 0; j < 4; ++j) {
    const motion::JointRange range = arm->range(int(j));
    const double unit = j == 2 ? 1.0 : std::numbers::pi / 180.0;
    c.limits[j].low = range.low;
    c.limits[j].high = range.high;
    if (machine.joint[j].rate > 0.0)
      c.limits[j].max_rate = std::min(c.limits[j].max_rate, machine.joint[j].rate * unit * kRateSlack);
  }
  c.tick_s = machine.tick_s;
  c.slip_s = e.ice.max_time_slip_s;
  c.host_latency_s = host_latency_s(e.run.time_scale);
  return c;
}

motion::Tool tool_named(const Machine& machine, const std::string& name) {
  for (motion::Tool& tool : tools(machine))
    if (tool.name == name) return tool;
  throw std::invalid_argument("machine: there is no tool \"" + name + "\"");
}

}  // namespace

RobotNode::RobotNode(const Experiment& e, const Machine& machine)
    : DriverNode(NodeId::kRobot, robot_config(e, machine)),
      arm_(make_arm(machine)),
      configuration_(preferred_configuration(machine)),
      tools_{tool_named(machine, "flange"), tool_named(machine, "water"), tool_named(machine, "scaffold"),
             laser_tool(machine, e)},
      origin_mm_{e.ice.origin_x_mm, e.ice.origin_y_mm, e.ice.origin_z_mm} {
  if (arm_->joints() != 4) throw std::invalid_argument("machine: the robot needs an arm of four joints");
  subscribe(channels::kTrajectory, this);
  subscribe(channels::kRobotCommand, this);
}

void RobotNode::on(const trajectory_t& m, Time now, Outbox& out) {
  act(now, out, [&](drivers::Robot& robot, std::int64_t now_us, drivers::Effects& fx) {
    robot.add_path(m.path, m.tick_s, m.axes, m.position, now_us, fx);
  });
}

// @throws motion::MotionError: out of reach or of a joint's range
drivers::fvp::Joints RobotNode::joints_of(const robot_command_t& c) const {
  const motion::Tool& tool = tools_[std::size_t(c.tool)];  // yaw 0: the tool's offset is not turned
  motion::TaskVector pose{};
  pose[0] = origin_mm_[0] + c.x_mm - tool.x_mm;
  pose[1] = origin_mm_[1] + c.y_mm - tool.y_mm;
  pose[2] = origin_mm_[2] + c.z_mm - tool.z_mm;
  const motion::JointVector q = arm_->inverse(pose, configuration_);
  return {q[0], q[1], q[2], q[3]};
}

void RobotNode::on(const robot_command_t& c, Time now, Outbox& out) {
  using drivers::Effects;
  using drivers::Robot;
  const drivers::PathPart part{c.path, c.from_sample, c.to_sample};
  switch (RobotVerb(c.verb)) {
    case RobotVerb::kHome:
      return perform(c, false, now, out,
                     [](Robot& robot, std::int64_t now_us, Effects& fx) { robot.home(now_us, fx); });
    case RobotVerb::kLoad:
      return perform(c, false, now, out,
                     [&](Robot& robot, std::int64_t now_us, Effects& fx) { robot.load(part, now_us, fx); });
    case RobotVerb::kRun: {
      const bool deposits = c.signals & (kSignalValveA | kSignalValveB);
      return perform(c, deposits, now, out, [&](Robot& robot, std::int64_t now_us, Effects& fx) {
        robot.run(part, c.signals, now_us, fx);
      });
    }
    case RobotVerb::kMove:
      return perform(c, false, now, out, [&](Robot& robot, std::int64_t now_us, Effects& fx) {
        try {
          const int percent = std::clamp(int(std::ceil(100.0 * c.speed_mm_s / kFullSpeed_mm_s)), 1, 100);
          robot.move_to(joints_of(c), percent, now_us, fx);
        } catch (const motion::MotionError& error) {
          robot.decline(error.what(), now_us, fx);
        }
      });
    case RobotVerb::kDrop:
      return perform(c, false, now, out,
                     [&](Robot& robot, std::int64_t now_us, Effects& fx) { robot.drop(c.path, now_us, fx); });
  }
}

std::unique_ptr<Node> make_robot(const std::string& config_toml, const Blobs& blobs) {
  const auto machine =
      std::find_if(blobs.begin(), blobs.end(), [](const Blob& b) { return b.role == "machine"; });
  const Machine arm = machine == blobs.end()
                          ? Machine{}
                          : parse_machine(std::string(reinterpret_cast<const char*>(machine->bytes.data()),
                                                      machine->bytes.size()),
                                          "machine");
  return std::make_unique<RobotNode>(parse_recorded_experiment(config_toml, "experiment.toml"), arm);
}

}  // namespace firn
