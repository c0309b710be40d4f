// RobotLab holds the robot's driver before a fake V+ program, and paths for both. The including test includes
// Catch.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "drivers/robot/robot.h"
#include "tests/drivers/fake_rig.h"
#include "tests/drivers/fake_robot.h"

namespace firn::drivers::test {

/// A smooth sweep of `n` points that begins at th1 = start; short ones are slow enough too.
inline std::vector<double> sweep(std::size_t n, double start = 0.1, double z_mm = 20.0) {
  std::vector<double> q;
  for (std::size_t k = 0; k < n; ++k) {
    const double u = double(k) / double(n - 1);
    const double s = u * u * (3 - 2 * u) * std::min(1.0, double(n) / 100.0);
    q.insert(q.end(), {start + 0.3 * s, -0.5 + 0.2 * s, z_mm, 0.4 - 0.5 * s});
  }
  return q;
}

/// The driver, wired to the program, homed by start().
struct RobotLab {
  FakeRobot fake;
  Robot robot;
  FakeRig<Robot, FakeRobot> rig;

  explicit RobotLab(RobotOptions config = {}) : robot(std::move(config)), rig(robot, fake) {}

  void start() {
    rig.open();
    REQUIRE(rig.run([&] { return robot.safe(); }, 10));
    rig.act([&](std::int64_t t, Effects& fx) { robot.home(t, fx); });
    REQUIRE(rig.run([&] { return !robot.busy(); }, 30));
    REQUIRE(rig.all<Result>().back().outcome == Outcome::kDone);
    rig.events.clear();
  }
  void give(std::int64_t path, const std::vector<double>& q) {
    rig.act([&](std::int64_t t, Effects& fx) { robot.add_path(path, 0.016, 4, q, t, fx); });
  }
  void begin(std::int64_t path, int signals = kSignalValveA) {
    rig.act([&](std::int64_t t, Effects& fx) { robot.run({path, 0, 0}, signals, t, fx); });
  }
  Result run(std::int64_t path, int signals = kSignalValveA, double limit_s = 400) {
    begin(path, signals);
    REQUIRE(rig.run([&] { return !robot.busy(); }, limit_s));
    return rig.all<Result>().back();
  }
};

}  // namespace firn::drivers::test
