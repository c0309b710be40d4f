#include "tests/drivers/ice_rig.h"

#include <catch2/catch.hpp>

namespace firn::drivers::test {
namespace {

plant::WorldConfig world_config(const plant::IceWorldConfig& ice, std::uint64_t seed) {
  plant::WorldConfig c;
  c.kind = &plant::kIceWorld;
  c.seed = seed;
  c.ice = ice;
  return c;
}

ValveOptions valve_config(int valve) {
  ValveOptions c;
  c.valve = valve;
  return c;
}

LaserPointOptions laser_config() {
  LaserPointOptions c;
  c.sampling_us = 200;
  c.averaging = 2;
  return c;
}

}  // namespace

IceRig::IceRig(const plant::IceWorldConfig& ice, std::uint64_t seed, const RobotOptions& robot_options)
    : PortRig(world_config(ice, seed)),
      robot(robot_options),
      valve_a(valve_config(1)),
      valve_b(valve_config(2)),
      laser(laser_config()),
      heater(HeaterOptions{}) {
  add("robot", robot);
  add("valve_a", valve_a);
  add("valve_b", valve_b);
  add("laser_point", laser);
  add("heater", heater);
}

Result IceRig::command(std::string_view name, const Act& f, double limit_s) {
  act(name, f);
  REQUIRE(run([&] { return !driver(name).busy(); }, limit_s));
  return all<Result>(name).back();
}

void IceRig::start() {
  connect_all();
  REQUIRE(command("robot", [&](std::int64_t t, Effects& fx) { robot.home(t, fx); }).outcome ==
          Outcome::kDone);
}

void IceRig::fault(std::string_view name, plant::FaultKind kind, std::int64_t count, std::int64_t delay_us) {
  plant::SimFault f;
  f.port = name;
  f.kind = kind;
  f.count = count;
  f.delay_us = delay_us;
  world.inject(f, now_us);
}

}  // namespace firn::drivers::test
