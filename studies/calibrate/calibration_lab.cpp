#include "studies/calibrate/calibration_lab.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>

#include "config/devices.h"
#include "config/ice_lab.h"
#include "core/motion/planner.h"
#include "core/options/for_people.h"
#include "firn/enums.h"
#include "firn/heater_command_t.hpp"
#include "firn/laser_command_t.hpp"
#include "firn/laser_samples_t.hpp"
#include "firn/pulse_list_t.hpp"
#include "firn/robot_command_t.hpp"
#include "firn/temperature_t.hpp"
#include "firn/trajectory_t.hpp"
#include "firn/valve_command_t.hpp"
#include "lcmtypes/convert.h"
#include "plant/world/ice_lab.h"
#include "print/device/simulated_instruments.h"
#include "print/simulated/plant_world.h"
#include "procs/heater/node.h"
#include "procs/laser_point/node.h"
#include "procs/robot/node.h"
#include "procs/safety/node.h"
#include "procs/valve/node.h"
#include "studies/calibrate/commanded_lab.h"

namespace firn {
namespace {

constexpr double kReady_s = 120.0, kWarm_s = 3600.0, kAnswer_s = 60.0, kUpload_s = 60.0;
// The arm comes down in steps until the laser, which sees 5 mm either way, has a reading. At the height of
// the laser's reference distance the nozzles are still 1 mm above the surface or more.
constexpr double kFrom_mm = 16.0, kTo_mm = -11.0, kStep_mm = 3.0;
constexpr double kSettle_s = 1.0;      // of the arm and of its end effector
constexpr double kMove_mm_s = 1000.0;  // between points, as fast as the approach to a path
constexpr std::pair<NodeId, MakeNode> kNodes[] = {
    {NodeId::kRobot, &make_robot},    {NodeId::kValveA, &make_valve_a},
    {NodeId::kValveB, &make_valve_b}, {NodeId::kLaserPoint, &make_laser_point},
    {NodeId::kHeater, &make_heater},  {NodeId::kSafety, &make_safety}};

}  // namespace

bool has_calibrations(const Experiment& e) {
  return std::ranges::all_of(kNodes, [&](const auto& node) { return takes_part(e, info(node.first).name); });
}

namespace {

const Experiment& checked(const Experiment& e) {
  if (!has_calibrations(e))
    throw std::invalid_argument("lab.kind = \"" + e.lab.kind + "\": only an ice lab has these calibrations");
  return e;
}

Blobs machine_input(const std::string& toml) {
  const auto* bytes = reinterpret_cast<const std::byte*>(toml.data());
  return {{"machine", "", {bytes, bytes + toml.size()}}};
}

}  // namespace

struct CalibrationLab::State final : CommandedLab {
  State(const Experiment& e, const std::string& machine_toml, Weigh balance)
      : CommandedLab(checked(e), kNodes, machine_input(machine_toml)),
        experiment(e),
        machine(parse_machine(machine_toml, e.ice.machine)),
        arm(make_arm(machine)),
        weigh(std::move(balance)) {}

  void heard(std::string_view channel, std::span<const std::byte> bytes) override {
    if (channel == channels::kLaserSamples.name) samples = decoded<laser_samples_t>(bytes);
    if (channel == channels::kTemperature.name) temperature = decoded<temperature_t>(bytes);
  }

  std::int64_t load(const Trajectory& motion) {
    PlannedPath p{1, 0, PathKind::kMeasurement, 0.0, motion};
    p.trajectory.id = ++path;
    send(NodeId::kPathPlanner, channels::kTrajectory, to_message(p));
    robot(RobotVerb::kLoad, 0, kUpload_s, "loading a path");
    return path;
  }

  void robot(RobotVerb verb, int signals, double seconds, const std::string& what) {
    robot_command_t c{};
    c.verb = std::int8_t(verb);
    c.path = verb == RobotVerb::kHome ? 0 : path;
    c.signals = signals;
    command(channels::kRobotCommand, c, seconds, what);
  }

  Experiment experiment;
  Machine machine;
  std::unique_ptr<motion::Arm> arm;
  Weigh weigh;
  std::int64_t path = 0;
  int weighings = 0;
  std::optional<laser_samples_t> samples;
  std::optional<temperature_t> temperature;
};

CalibrationLab::CalibrationLab(const Experiment& e, const std::string& machine_toml, Weigh weigh)
    : state_(std::make_unique<State>(e, machine_toml, std::move(weigh))) {}
CalibrationLab::~CalibrationLab() = default;

const Experiment& CalibrationLab::experiment() const { return state_->experiment; }
const Machine& CalibrationLab::machine() const { return state_->machine; }
double CalibrationLab::now_s() const { return state_->now_s(); }
void CalibrationLab::wait(double seconds) { state_->wait(seconds); }

motion::Tool CalibrationLab::tool(const std::string& name) const {
  if (name == "laser") return laser_tool(state_->machine, state_->experiment);
  for (motion::Tool& t : tools(state_->machine))
    if (t.name == name) return t;
  throw std::invalid_argument("machine: there is no tool \"" + name + "\"");
}

void CalibrationLab::get_ready() {
  State& s = *state_;
  s.get_safe(kReady_s);
  heater_command_t h{};
  h.verb = std::int8_t(HeaterVerb::kSet);
  h.set_degC[0] = s.experiment.heater.tip_degC;
  h.set_degC[1] = s.experiment.heater.window_degC;
  h.set_degC[2] = s.experiment.heater.conduit_degC;
  s.command(channels::kHeaterCommand, h, kAnswer_s, "heating");
  s.until([&] { return s.temperature && s.temperature->degC[0] >= s.experiment.heater.low_degC; }, kWarm_s,
          "warming the tip");
  s.robot(RobotVerb::kHome, 0, kReady_s, "homing");
}

Trajectory CalibrationLab::plan(const LabPass& pass) const {
  const State& s = *state_;
  motion::PathInput in;
  in.points = pass.points;
  in.kind = PathKind::kMeasurement;
  in.origin = {s.experiment.ice.origin_x_mm, s.experiment.ice.origin_y_mm};
  in.z_mm = s.experiment.ice.origin_z_mm + pass.z_mm;
  in.yaw_rad = pass.yaw_rad;
  in.tool = pass.tool;
  in.speed_limit.path_mm_s = std::min(pass.speed_mm_s, s.machine.position.rate);
  in.preferred = preferred_configuration(s.machine);
  motion::PlanOptions options;
  options.tick_s = s.machine.tick_s;
  options.lower_bound = false;
  motion::PlanResult r = motion::plan(in, *s.arm, motion_limits(s.machine), options);
  if (!r.ok()) throw std::runtime_error("a pass cannot be run: " + motion::describe(*r.fault));
  return std::move(r.trajectory);
}

Trajectory CalibrationLab::stand(const LabPass& pass, double seconds) const {
  const State& s = *state_;
  motion::Jets tool(motion::kTaskAxes, 1), flange(motion::kTaskAxes, 1);
  for (int axis = 0; axis < motion::kTaskAxes; ++axis)
    for (int order = 0; order < 4; ++order) tool.of(axis, order)[0] = 0.0;
  tool.of(motion::kX, 0)[0] = s.experiment.ice.origin_x_mm + pass.points.at(0).x_mm;
  tool.of(motion::kY, 0)[0] = s.experiment.ice.origin_y_mm + pass.points.at(0).y_mm;
  tool.of(motion::kZ, 0)[0] = s.experiment.ice.origin_z_mm + pass.z_mm;
  tool.of(motion::kYaw, 0)[0] = pass.yaw_rad;
  motion::tool_to_flange(pass.tool, tool, flange);
  motion::TaskVector pose{};
  for (int axis = 0; axis < motion::kTaskAxes; ++axis) pose[std::size_t(axis)] = flange.of(axis, 0)[0];
  const motion::JointVector q = s.arm->inverse(pose, preferred_configuration(s.machine));
  Trajectory t;
  t.tick_s = s.machine.tick_s;
  t.axes = s.arm->joints();
  for (int a = 0; a < t.axes; ++a) t.axis_units.push_back(s.arm->joint_unit(a));
  const auto samples = std::size_t(std::ceil(seconds / t.tick_s)) + 1;
  for (std::size_t n = 0; n < samples; ++n)
    t.positions.insert(t.positions.end(), q.begin(), q.begin() + t.axes);
  t.certificate.duration_s = double(samples - 1) * t.tick_s;
  return t;
}

std::vector<float> CalibrationLab::scan(const Trajectory& motion, int material) {
  State& s = *state_;
  s.load(motion);
  laser_command_t c{};
  c.verb = std::int8_t(LaserVerb::kArm);
  c.path = s.path;
  c.count = 1;
  c.material = std::int8_t(material);
  c.period_s = 1.0 / s.experiment.laser_point.rate_hz;
  c.samples = std::int32_t(std::clamp(std::ceil(motion.certificate.duration_s / c.period_s), 1.0, 65536.0));
  s.command(channels::kLaserCommand, c, kAnswer_s, "arming the laser");
  s.robot(RobotVerb::kRun, kSignalLaser, motion.certificate.duration_s + kUpload_s, "a pass of the laser");
  s.samples.reset();
  c.verb = std::int8_t(LaserVerb::kCollect);
  s.command(channels::kLaserCommand, c, kAnswer_s, "collecting the readings");
  if (!s.samples) throw std::runtime_error("the laser has told no readings");
  return std::move(s.samples->distance_mm);
}

double CalibrationLab::reading(double x_mm, double y_mm, double z_mm) {
  State& s = *state_;
  robot_command_t c{};
  c.verb = std::int8_t(RobotVerb::kMove);
  c.tool = std::int8_t(RobotTool::kLaser);
  c.x_mm = x_mm;
  c.y_mm = y_mm;
  c.z_mm = z_mm;
  c.speed_mm_s = kMove_mm_s;
  s.command(channels::kRobotCommand, c, kAnswer_s, "moving to a point");
  s.wait(kSettle_s);
  s.samples.reset();
  laser_command_t l{};
  l.verb = std::int8_t(LaserVerb::kReading);
  l.count = 1;
  l.samples = 1;
  l.period_s = 1.0 / s.experiment.laser_point.rate_hz;
  s.command(channels::kLaserCommand, l, kAnswer_s, "reading the laser");
  return s.samples && s.samples->n > 0 ? double(s.samples->distance_mm[0])
                                       : std::numeric_limits<double>::quiet_NaN();
}

bool CalibrationLab::reaches(double x_mm, double y_mm) const try {
  stand({{{x_mm, y_mm}}, tool("laser"), 0.0}, 0.0);
  return true;
} catch (const motion::MotionError&) {
  return false;
}

double CalibrationLab::surface_mm(double x_mm, double y_mm) {
  for (double z = kFrom_mm; z >= kTo_mm; z -= kStep_mm)
    if (const double seen = reading(x_mm, y_mm, z); std::isfinite(seen))
      return z + seen + state_->experiment.laser_point.offset_z_mm;
  throw std::runtime_error("the laser sees nothing at (" + for_people(x_mm) + ", " + for_people(y_mm) +
                           ") mm down to " + for_people(kTo_mm) + " mm");
}

std::int64_t CalibrationLab::fire(const Trajectory& motion, int material,
                                  const std::vector<std::int32_t>& ticks) {
  State& s = *state_;
  const bool b = material == 1;
  const ValveLineConfig& valve = b ? s.experiment.valve_b : s.experiment.valve_a;
  s.load(motion);
  pulse_list_t list{};
  list.path = s.path;
  list.lists = 1;
  list.valve = std::int8_t(b ? ValveId::kB : ValveId::kA);
  list.tick_s = list_limits(s.machine, s.experiment).tick_s;
  list.pulse_s = valve.pulse_us * 1e-6;
  list.n = std::int32_t(ticks.size());
  list.tick = ticks;
  s.send(NodeId::kPathPlanner, channels::kPulseList, std::move(list));
  valve_command_t v{};
  v.path = s.path;
  v.expected = std::int64_t(ticks.size());
  const auto& channel = b ? channels::kValveBCommand : channels::kValveACommand;
  for (const ValveVerb verb : {ValveVerb::kLoad, ValveVerb::kArm}) {
    v.verb = std::int8_t(verb);
    s.command(channel, v, kUpload_s, "loading and arming the valve");
  }
  s.robot(RobotVerb::kRun, b ? kSignalValveB : kSignalValveA, motion.certificate.duration_s + kUpload_s,
          "running a path with pulses");
  v.verb = std::int8_t(ValveVerb::kDisarm);
  return s.command(channel, v, kAnswer_s, "disarming the valve").counted;
}

double CalibrationLab::tip_degC() const {
  return state_->temperature ? state_->temperature->degC[0] : std::numeric_limits<double>::quiet_NaN();
}
double CalibrationLab::weigh_mg(int material) {
  const int n = ++state_->weighings;
  if (const PlantWorld* plant = state_->simulated())
    return plant->world().ice()->weighed_mg(material, std::uint32_t(n));
  const bool real = outside_ports(state_->experiment).contains(material == 1 ? "valve_b" : "valve_a");
  if (!real) return state_->beside()->weighed_mg(material, n);
  if (!state_->weigh) throw std::runtime_error("a lab with real ports needs somebody who reads its balance");
  return state_->weigh(material, n);
}

}  // namespace firn
