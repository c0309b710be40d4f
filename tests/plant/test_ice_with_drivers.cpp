// Drivers and twins of the ice lab were written apart, each from the protocol cards: here they meet, byte for
// byte.
#include <catch2/catch.hpp>

#include <cmath>
#include <functional>
#include <map>

#include "drivers/heater/heater.h"
#include "drivers/laser_point/laser_point.h"
#include "drivers/robot/robot.h"
#include "drivers/valve/valve.h"
#include "plant/world/ice_lab.h"
#include "tests/plant/driver_rig.h"
#include "tests/support/ice_paths.h"

using namespace firn;
using namespace firn::plant;

namespace {

WorldConfig ice_world() {
  WorldConfig c;
  c.kind = &kIceWorld;
  c.ice.field = {0.3, -25.0, -25.0, 50.0, 50.0};
  c.ice.disturbance.debris_per_h = 0.0;
  return c;
}

struct PathPrinterRig : DriverRig {
  explicit PathPrinterRig(const WorldConfig& config)
      : DriverRig(config, 180'000'000),
        robot(drivers::RobotOptions{}),
        valve_a(drivers::ValveOptions{}),
        laser(drivers::LaserPointOptions{}),
        heater(drivers::HeaterOptions{}) {
    connect(
        {{kRobotPort, &robot}, {kValveAPort, &valve_a}, {kLaserPointPort, &laser}, {kHeaterPort, &heater}});
  }
  void add(std::int64_t path, const ice_paths::Run& run) {
    std::vector<double> rows;
    for (const Joints& q : run.points) rows.insert(rows.end(), q.begin(), q.end());
    call(kRobotPort,
         [&](drivers::Driver&, drivers::Effects& fx) { robot.add_path(path, 0.016, 4, rows, now_us, fx); });
    if (run.ticks.empty()) return;
    const std::vector<std::int32_t> ticks(run.ticks.begin(), run.ticks.end());
    call(kValveAPort, [&](drivers::Driver&, drivers::Effects& fx) {
      valve_a.add_list({path, 0}, 0.002, 0.00125, ticks, now_us, fx);
    });
  }
  drivers::Result arm(std::int64_t path) {
    const auto loaded = command(kValveAPort, [&](drivers::Driver&, drivers::Effects& fx) {
      valve_a.load({path, 0}, now_us, fx);
    });
    CHECK(loaded.outcome == Outcome::kDone);
    return command(kValveAPort, [&](drivers::Driver&, drivers::Effects& fx) {
      valve_a.arm({path, 0}, now_us, fx);
    });
  }
  void start() {
    REQUIRE(until([&] { return all_safe(); }));
    CHECK(command(kRobotPort, [&](drivers::Driver&, drivers::Effects& fx) {
            robot.home(now_us, fx);
          }).outcome == Outcome::kDone);
    CHECK(command(kHeaterPort, [&](drivers::Driver&, drivers::Effects& fx) {
            heater.set({20.0, 22.0, 20.0}, now_us, fx);
          }).outcome == Outcome::kDone);
  }

  drivers::Robot robot;
  drivers::Valve valve_a;
  drivers::LaserPoint laser;
  drivers::Heater heater;
};

ice_paths::Run deposition(const IceWorldConfig& c, double y_mm, double speed = 60.0) {
  return ice_paths::along(
      c.arm, c.arm.valve_a, {{-15.0, y_mm}, {15.0, y_mm}}, 3.24, speed, 1.5, [](double) { return 0.25; },
      ice_paths::calibrated_late_s(c, 0) - c.valve[0].trigger_delay_s);
}

}  // namespace

TEST_CASE("The drivers home the robot, print a bead, count its pulses and measure it with the laser") {
  const WorldConfig config = ice_world();
  PathPrinterRig rig(config);
  rig.start();
  const auto run = deposition(config.ice, 2.0);
  rig.add(1, run);
  const auto armed = rig.arm(1);
  INFO(armed.text);
  CHECK(armed.outcome == Outcome::kReady);
  const auto ran = rig.command(kRobotPort, [&](drivers::Driver&, drivers::Effects& fx) {
    rig.robot.run({1, 0, 0}, drivers::kSignalValveA, rig.now_us, fx);
  });
  INFO(ran.text);
  REQUIRE(ran.outcome == Outcome::kDone);
  CHECK(std::abs(ran.counted - ran.expected) < 16'000);
  const auto fired = rig.command(
      kValveAPort, [&](drivers::Driver&, drivers::Effects& fx) { rig.valve_a.disarm(rig.now_us, fx); });
  CHECK(fired.outcome == Outcome::kDone);
  CHECK(fired.counted == std::int64_t(run.ticks.size()));
  CHECK(rig.world.ice()->ice_truth().pulses[0] == std::int64_t(run.ticks.size()));

  auto look = ice_paths::along(
      config.ice.arm, config.ice.arm.laser, {{-20.0, 2.0}, {20.0, 2.0}}, 0.24, 50.0, 1.5,
      [](double) { return 0.25; }, 0.0);
  look.ticks.clear();
  rig.add(2, look);
  const int samples = int(100.0 * look.duration_s);
  CHECK(rig.command(kLaserPointPort,
                    [&](drivers::Driver&, drivers::Effects& fx) {
                      rig.laser.arm(0, samples, 0.01, rig.now_us, fx);
                    })
            .outcome == Outcome::kReady);
  CHECK(rig.command(kRobotPort,
                    [&](drivers::Driver&, drivers::Effects& fx) {
                      rig.robot.run({2, 0, 0}, drivers::kSignalLaser, rig.now_us, fx);
                    })
            .outcome == Outcome::kDone);
  const auto collected = rig.command(
      kLaserPointPort, [&](drivers::Driver&, drivers::Effects& fx) { rig.laser.collect(rig.now_us, fx); });
  CHECK(collected.outcome == Outcome::kDone);
  REQUIRE(rig.all<drivers::Samples>().size() == 1);
  const std::vector<float> z = rig.all<drivers::Samples>()[0].z_mm;
  CHECK(int(z.size()) >= samples - 3);
  double on_bead = 0.0, beside = 0.0;
  int n = 0, m = 0;
  for (std::size_t k = 0; k < z.size(); ++k) {
    const double x = -20.0 + 50.0 * (double(k) * 0.01 - 0.05 - 0.028);  // ramp, start delay and servo lag
    if (std::isnan(z[k])) continue;
    if (std::abs(x) < 12.0) {
      on_bead += z[k];
      ++n;
    }
    if (std::abs(x) > 18.0) {
      beside += z[k];
      ++m;
    }
  }
  CHECK(on_bead / n - beside / m == Approx(0.24).margin(0.1));  // lines of bead 0.24 mm thick
  for (const std::string& fault : rig.faults) WARN(fault);
  CHECK(rig.faults.empty());
  CHECK(rig.world.ice()->ice_truth().collisions.contacts == 0);
}

TEST_CASE(
    "A stop in the middle of a path: the arm rests, the valve is closed, both say how far they came, and "
    "nature agrees") {
  const WorldConfig config = ice_world();
  PathPrinterRig rig(config);
  rig.start();
  const auto run = deposition(config.ice, -4.0, 10.0);
  rig.add(1, run);
  REQUIRE(rig.arm(1).outcome == Outcome::kReady);
  rig.call(kRobotPort, [&](drivers::Driver&, drivers::Effects& fx) {
    rig.robot.run({1, 0, 0}, drivers::kSignalValveA, rig.now_us, fx);
  });
  REQUIRE(rig.until([&] { return rig.world.ice()->ice_truth().pulses[0] > 10; }));
  const std::int64_t stop_us = rig.now_us;
  for (const auto port : {kRobotPort, kValveAPort})
    rig.call(port, [&](drivers::Driver& d, drivers::Effects& fx) { d.safe_stop(rig.now_us, fx); });
  REQUIRE(rig.until([&] { return rig.valve_a.safe() && rig.robot.safe(); }));
  CHECK(rig.world.ice()->ice_truth().last_pulse_us[0] < stop_us + 100'000);
  REQUIRE(rig.results["robot"].size() >= 2);
  CHECK(rig.results["robot"].back().outcome == Outcome::kFailed);
  const auto count = rig.command(
      kValveAPort, [&](drivers::Driver&, drivers::Effects& fx) { rig.valve_a.disarm(rig.now_us, fx); });
  CHECK(count.outcome == Outcome::kFailed);
  CHECK(count.counted == rig.world.ice()->ice_truth().pulses[0]);
}
