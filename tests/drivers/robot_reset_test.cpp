// Latched faults of the robot, and the ways to clear them.
#include <catch2/catch.hpp>

#include "tests/drivers/robot_lab.h"

using namespace firn::drivers;
using firn::DeviceState;
using firn::Outcome;
using firn::drivers::test::sweep;
using Lab = firn::drivers::test::RobotLab;

TEST_CASE("an emergency stop latches until it is homed with the button released", "[robot][I1]") {
  Lab lab;
  lab.start();
  lab.give(1, sweep(500));
  lab.give(2, sweep(100));
  lab.begin(1);
  lab.rig.run_for(4.0);
  lab.fake.take("", lab.rig.now_us);
  lab.fake.status.state = fvp::State::kEstop;
  lab.fake.status.running = 0;
  lab.fake.status.last = 1;
  REQUIRE(lab.rig.run([&] { return lab.robot.state() == DeviceState::kEstop; }, 10));
  CHECK(lab.rig.faulted(kEstop));
  CHECK_FALSE(lab.robot.busy());
  CHECK(lab.run(2).outcome == Outcome::kRefused);
  lab.rig.run_for(3.0);
  CHECK(lab.robot.state() == DeviceState::kEstop);
  lab.rig.act([&](std::int64_t t, Effects& fx) { lab.robot.home(t, fx); });
  REQUIRE(lab.rig.run([&] { return lab.robot.safe() && !lab.robot.busy(); }, 30));
  CHECK(lab.run(2).outcome == Outcome::kDone);
}

TEST_CASE(
    "what latched is cleared at the first look round after the operator's resume, at no other, and not with "
    "the button pressed",
    "[robot]") {
  for (const fvp::State latched : {fvp::State::kEstop, fvp::State::kFault}) {
    const auto cleared = [&](bool resumed, bool pressed) {
      Lab lab;
      lab.start();
      lab.fake.status.state = latched;
      lab.fake.status.error = -1006;
      lab.fake.pressed = pressed;
      if (resumed) lab.robot.permit_reset();
      lab.rig.close();
      lab.rig.run_for(8.0);
      CHECK(lab.robot.safe() == (lab.fake.status.state == fvp::State::kIdle));
      if (!lab.robot.safe()) return false;
      lab.fake.status.state = latched;  // once only
      lab.rig.close();
      lab.rig.run_for(8.0);
      CHECK_FALSE(lab.robot.safe());
      return true;
    };
    CHECK(cleared(true, false));
    CHECK_FALSE(cleared(false, false));
    CHECK_FALSE(cleared(true, true));
  }
}
