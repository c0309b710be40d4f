// The drivers of the path printer against the simulated world: motion, pulses and readings go together, and
// whatever is lost or breaks, nothing is deposited twice and no count is wrong.
#include <catch2/catch.hpp>
#include <cmath>

#include "plant/twins/vplus_robot.h"
#include "tests/drivers/bench.h"
#include "tests/drivers/ice_rig.h"
#include "tests/drivers/lossy_line.h"
#include "tests/plant/vplus_text.h"

using namespace firn::drivers;
using firn::DeviceState;
using firn::Outcome;
using firn::Severity;
using firn::drivers::test::IceRig;
using firn::drivers::test::next;
using firn::plant::FaultKind;

namespace {

// A joint sweep of `n` ticks from rest to rest above the table, `k` shifts it.
std::vector<double> sweep(std::size_t n, int k = 0) {
  std::vector<double> q;
  for (std::size_t i = 0; i < n; ++i) {
    const double u = double(i) / double(n - 1), s = u * u * (3 - 2 * u) * std::min(1.0, double(n) / 400.0);
    q.insert(q.end(), {-0.9 + 0.02 * k + 0.15 * s, 1.6 - 0.1 * s, 24.0, -0.7 - 0.02 * k - 0.05 * s});
  }
  return q;
}

std::vector<std::int32_t> every(int n, int ticks) {
  std::vector<std::int32_t> list;
  for (int k = 0; k < n; ++k) list.push_back(k * ticks);
  return list;
}

void give(IceRig& rig, std::int64_t path, std::size_t points, int pulses) {
  rig.act("robot", [&](std::int64_t t, Effects& fx) {
    rig.robot.add_path(path, 0.016, 4, sweep(points, int(path % 7)), t, fx);
  });
  rig.act("valve_a", [&](std::int64_t t, Effects& fx) {
    rig.valve_a.add_list({path, 0}, 0.002, 0.00125, every(pulses, 8), t, fx);
  });
}

Result load_valve(IceRig& rig, std::int64_t path) {
  return rig.command("valve_a", [&](std::int64_t t, Effects& fx) { rig.valve_a.load({path, 0}, t, fx); });
}
Result arm_valve(IceRig& rig, std::int64_t path) {
  return rig.command("valve_a", [&](std::int64_t t, Effects& fx) { rig.valve_a.arm({path, 0}, t, fx); });
}
Result disarm(IceRig& rig) {
  return rig.command("valve_a", [&](std::int64_t t, Effects& fx) { rig.valve_a.disarm(t, fx); });
}
void begin_run(IceRig& rig, std::int64_t path, int signals) {
  rig.act("robot", [&](std::int64_t t, Effects& fx) { rig.robot.run({path, 0, 0}, signals, t, fx); });
}
std::int64_t fired(const IceRig& rig) { return rig.world.ice()->ice_truth().pulses[0]; }

/// Runs four paths of 500 points, with 400 pulses each: each is over within `slack_us` of its time, and every
/// pulse is given and counted once.
void run_four_paths(IceRig& rig, std::int64_t slack_us) {
  std::int64_t before = 0;
  for (int path = 1; path <= 4; ++path) give(rig, path, 500, 400);
  for (int path = 1; path <= 4; ++path) {
    REQUIRE(load_valve(rig, path).outcome == Outcome::kDone);
    REQUIRE(arm_valve(rig, path).outcome == Outcome::kReady);
    begin_run(rig, path, kSignalValveA);
    REQUIRE(rig.run([&] { return !rig.robot.busy(); }, 60));
    const Result run = rig.all<Result>("robot").back();
    INFO(test::describe(run));
    CHECK(run.outcome == Outcome::kDone);
    CHECK(std::abs(run.counted - run.expected) <= slack_us);
    const Result count = disarm(rig);
    CHECK(count.outcome == Outcome::kDone);
    CHECK(count.counted == 400);
    CHECK(fired(rig) - before == 400);
    before = fired(rig);
  }
  for (const char* port : {"robot", "valve_a", "valve_b", "laser_point", "heater"})
    CHECK(rig.all<Fault>(port).empty());
}

}  // namespace

TEST_CASE("paths are run in their time and every pulse of their lists is given once", "[ice_world]") {
  IceRig rig;
  rig.start();
  run_four_paths(rig, 1000);
}

TEST_CASE("paths are run and pulses given once where robot and valves execute their own programs",
          "[ice_world]") {
  firn::plant::IceWorldConfig c;
  c.robot = firn::plant::shipped_program();
  for (firn::plant::IceValveParams& v : c.valve) v.firmware = true;
  RobotOptions options;
  options.block_lines = 4;  // a reply within 0.25 s of a controller of 160 statements in a tick
  IceRig rig(c, 1, options);
  rig.run_for(2.0);  // the V+ program makes its table
  rig.start();
  run_four_paths(rig, 3000);
  CHECK(rig.world.ice()->vplus_robot()->late_segments() == 0);
  begin_run(rig, 4, kSignalLaser);  // and a stop in its way
  rig.run_for(1.0);
  rig.act("robot", [&](std::int64_t t, Effects& fx) { rig.driver("robot").safe_stop(t, fx); });
  rig.run_for(5.0);
  CHECK_FALSE(rig.world.ice()->nature().arm().commanded());
}

TEST_CASE("the laser stores along the path and gives one value per period", "[ice_world]") {
  IceRig rig;
  rig.start();
  give(rig, 1, 600, 1);
  for (const int material : {0, 1}) {
    REQUIRE(rig.command("laser_point",
                        [&](std::int64_t t, Effects& fx) { rig.laser.arm(material, 1000, 0.01, t, fx); })
                .outcome == Outcome::kReady);
    begin_run(rig, 1, kSignalLaser);
    REQUIRE(rig.run([&] { return !rig.robot.busy(); }, 60));
    CHECK(rig.all<Result>("robot").back().outcome == Outcome::kDone);
    const Result r =
        rig.command("laser_point", [&](std::int64_t t, Effects& fx) { rig.laser.collect(t, fx); });
    CHECK(r.outcome == Outcome::kDone);
    CHECK(std::abs(double(r.counted) - 599 * 0.016 / 0.01) <= 2.0);
    CHECK(rig.all<Samples>("laser_point").back().z_mm.size() == std::size_t(r.counted));
  }
}

TEST_CASE("the heaters hold their set points, and (a) breaks and (b) goes on alone", "[ice_world][I10]") {
  IceRig rig;
  rig.start();
  CHECK(rig.command("heater",
                    [&](std::int64_t t, Effects& fx) {
                      rig.heater.set({20, 22, 20}, t, fx);
                    })
            .outcome == Outcome::kDone);
  rig.run_for(600);
  for (std::size_t c = 0; c < 3; ++c)
    CHECK(std::abs(rig.all<Temperatures>("heater").back().celsius[c] - (c == 1 ? 22 : 20)) < 4.0);
  CHECK(rig.all<Fault>("heater").empty());
  rig.fault("heater", FaultKind::kTrip, 1);
  REQUIRE(rig.run([&] { return !rig.all<Fault>("heater").empty(); }, 600));
  CHECK(rig.all<Fault>("heater").back().severity == Severity::kWarning);
  CHECK(rig.heater.keeps_warm());
  rig.fault("heater", FaultKind::kTrip, 5);  // thermocouple of (b)
  REQUIRE(rig.run([&] { return !rig.heater.keeps_warm(); }, 600));
  CHECK(rig.all<Fault>("heater").back().severity == Severity::kStop);
}

TEST_CASE("a stop in the middle: flow ends first, the counts are the world's", "[ice_world]") {
  std::uint64_t seed = 5;
  for (int round = 0; round < 8; ++round) {
    IceRig rig;
    rig.start();
    give(rig, 1, 500, 450);
    load_valve(rig, 1);
    arm_valve(rig, 1);
    begin_run(rig, 1, kSignalValveA);
    rig.run_for(double(next(seed) % 9000) * 1e-3);
    const double z_before = rig.robot.joints() ? (*rig.robot.joints())[2] : 0.0;
    const bool was_busy = rig.robot.busy();
    for (const char* port : {"valve_a", "robot", "valve_b", "laser_point", "heater"})
      rig.act(port, [&](std::int64_t t, Effects& fx) { rig.driver(port).safe_stop(t, fx); });
    rig.run_for(0.01);
    const std::int64_t shots = fired(rig);
    REQUIRE(rig.run([&] { return rig.robot.safe() && rig.valve_a.safe() && !rig.robot.busy(); }, 15));
    rig.run_for(3.0);
    CHECK(fired(rig) <= shots + 1);
    CHECK(disarm(rig).counted == fired(rig));
    if (was_busy) CHECK((*rig.robot.joints())[2] >= std::min(z_before, 24.0));
    CHECK(rig.world.ice()->ice_truth().collisions.contacts == 0);
  }
}

TEST_CASE("killed drivers come back and tell what the world has done", "[ice_world]") {
  std::uint64_t seed = 15;
  int cut = 0;
  for (int round = 0; round < 10; ++round) {
    IceRig rig;
    rig.start();
    give(rig, 1, 400, 380);
    load_valve(rig, 1);
    arm_valve(rig, 1);
    begin_run(rig, 1, kSignalValveA);
    rig.run_for(1.0 + double(next(seed) % 8000) * 1e-3);
    if (!rig.robot.busy()) continue;
    rig.kill("robot");
    rig.kill("valve_a");
    rig.run_for(double(next(seed) % 6000) * 1e-3);
    rig.resume("robot");
    rig.resume("valve_a");
    REQUIRE(rig.run([&] { return rig.robot.safe() && rig.valve_a.safe() && !rig.robot.busy(); }, 30));
    const Result r = rig.all<Result>("robot").back();
    INFO(test::describe(r));
    CHECK(r.outcome != Outcome::kUnknown);
    cut += r.outcome == Outcome::kFailed;
    CHECK(disarm(rig).counted == fired(rig));
    const std::int64_t before = fired(rig);
    CHECK((rig.all<Result>("robot").back().outcome == Outcome::kNone ||
           rig.command("robot", [&](std::int64_t t, Effects& fx) {
                rig.robot.run({1, 0, 0}, kSignalValveA, t, fx);
              }).outcome == Outcome::kRefused));
    rig.run_for(5.0);
    CHECK(fired(rig) == before);
  }
  CHECK(cut > 2);
}

TEST_CASE("a valve's driver that dies in the middle of a frame is answered as soon as it is back",
          "[ice_world]") {
  for (int round = 0; round < 8; ++round) {
    IceRig rig;
    rig.start();
    give(rig, 1, 4000, 3000);
    rig.act("valve_a", [&](std::int64_t t, Effects& fx) { rig.valve_a.load({1, 0}, t, fx); });
    rig.run_for(0.010 + 0.011 * round);
    rig.kill("valve_a");
    rig.run_for(0.3);
    rig.resume("valve_a");
    INFO("round " << round);
    CHECK(rig.run([&] { return rig.valve_a.safe(); }, 1.0));
    CHECK(load_valve(rig, 1).outcome == Outcome::kDone);
  }
}

TEST_CASE("under lost, late, cut and damaged replies, closed ports and reboots nothing is deposited twice",
          "[ice_world]") {
  std::uint64_t seed = 25;
  int done = 0;
  for (int round = 0; round < 16; ++round) {
    IceRig rig;
    rig.start();
    std::int64_t known = 0, doubt = 0;
    for (int path = 1; path <= 3; ++path) give(rig, path, 200, 150);
    for (int path = 1; path <= 3; ++path) {
      const auto trouble = [&] {
        if (next(seed) % 3 != 0) return;
        const FaultKind kinds[] = {FaultKind::kDropReply, FaultKind::kDelayReply, FaultKind::kSplitReply,
                                   FaultKind::kFlipBit,   FaultKind::kClose,      FaultKind::kReboot};
        const FaultKind kind = kinds[next(seed) % (round % 2 ? 4 : 6)];
        // One after the other: compilers evaluate arguments in orders of their own.
        const char* const port = next(seed) % 2 ? "robot" : "valve_a";
        const std::int64_t count = 1 + std::int64_t(next(seed) % 40),
                           delay_us = std::int64_t(next(seed) % 300'000);
        rig.fault(port, kind, count, kind == FaultKind::kSplitReply ? 300 : delay_us);
      };
      trouble();
      if (load_valve(rig, path).outcome != Outcome::kDone) break;
      trouble();
      if (arm_valve(rig, path).outcome != Outcome::kReady) break;
      begin_run(rig, path, kSignalValveA);
      rig.run_for(double(next(seed) % 3000) * 1e-3);
      trouble();
      REQUIRE(
          rig.run([&] { return !rig.robot.busy() && rig.robot.state() != DeviceState::kDisconnected; }, 60));
      const Result run = rig.all<Result>("robot").back();
      REQUIRE(rig.run(
          [&] {
            return rig.valve_a.state() != DeviceState::kDisconnected &&
                   rig.valve_a.state() != DeviceState::kConnecting &&
                   rig.valve_a.state() != DeviceState::kIdentifying;
          },
          120));  // forty late replies
      const Result count = disarm(rig);
      INFO("round " << round << " path " << path << " " << test::describe(run) << " | "
                    << test::describe(count));
      if (count.outcome == Outcome::kUnknown)
        doubt += count.unknown_to - count.counted;
      else
        CHECK(count.counted >= 0);
      known += std::max<std::int64_t>(count.counted, 0);
      CHECK(fired(rig) >= known);
      CHECK(fired(rig) <= known + doubt);
      if (run.outcome != Outcome::kDone) break;
      ++done;
    }
    CHECK(fired(rig) <= 450);
  }
  CHECK(done > 15);
}

TEST_CASE("a valve that is disarmed at its panel during a path never counts a pulse that it did not give",
          "[ice_world][power]") {
  std::uint64_t seed = 35;
  int cut = 0;
  for (int round = 0; round < 10; ++round) {
    IceRig rig;
    rig.start();
    give(rig, 1, 500, 450);
    load_valve(rig, 1);
    REQUIRE(arm_valve(rig, 1).outcome == Outcome::kReady);
    begin_run(rig, 1, kSignalValveA);
    rig.run_for(double(next(seed) % 8000) * 1e-3);
    rig.fault("valve_a", FaultKind::kTrip, 4);
    const std::int64_t given = fired(rig);
    REQUIRE(rig.run([&] { return !rig.robot.busy(); }, 60));
    CHECK(fired(rig) == given);
    const std::vector<Fault> faults = rig.all<Fault>("valve_a");
    CHECK((given == 450 || (!faults.empty() && faults[0].severity == Severity::kStop)));
    const Result count = disarm(rig);
    INFO("round " << round << ", " << given << " pulses given: " << test::describe(count));
    CHECK(std::max<std::int64_t>(count.counted, 0) <= given);
    CHECK(std::max(count.counted, count.unknown_to) >= given);
    CHECK((count.outcome != Outcome::kDone || given == 450));
    cut += given < 450;
  }
  CHECK(cut > 5);
}

TEST_CASE("a valve that never arms stops the path by name, and gives no pulse", "[ice_world][power]") {
  IceRig rig;
  rig.start();
  give(rig, 1, 500, 450);
  load_valve(rig, 1);
  rig.fault("valve_a", FaultKind::kTrip, 5);
  REQUIRE(arm_valve(rig, 1).outcome == Outcome::kReady);  // it acknowledges all the same
  begin_run(rig, 1, kSignalValveA);
  rig.run_for(1.0);
  REQUIRE(rig.robot.busy());
  const std::vector<Fault> faults = rig.all<Fault>("valve_a");
  REQUIRE(faults.size() == 1);
  CHECK(faults[0].severity == Severity::kStop);
  CHECK_THAT(faults[0].text, Catch::Contains("not armed any more") && Catch::Contains("0 of 450"));
  REQUIRE(rig.run([&] { return !rig.robot.busy(); }, 60));
  CHECK(fired(rig) == 0);
  const Result count = disarm(rig);
  CHECK(count.outcome == Outcome::kNone);
  CHECK(count.counted == 0);
  rig.fault("valve_a", FaultKind::kTrip, 0);
  load_valve(rig, 1);
  CHECK(arm_valve(rig, 1).outcome == Outcome::kReady);
}

TEST_CASE("an emergency stop in the middle of a path stops arm and flow, and needs homing", "[ice_world]") {
  IceRig rig;
  rig.start();
  give(rig, 1, 500, 400);
  load_valve(rig, 1);
  arm_valve(rig, 1);
  begin_run(rig, 1, kSignalValveA);
  rig.run_for(5.0);
  rig.fault("robot", FaultKind::kTrip, 1);
  REQUIRE(rig.run([&] { return rig.robot.state() == DeviceState::kEstop; }, 10));
  CHECK(rig.all<Result>("robot").back().outcome == Outcome::kFailed);
  CHECK(rig.command("robot", [&](std::int64_t t, Effects& fx) { rig.robot.home(t, fx); }).outcome ==
        Outcome::kFailed);
  CHECK(rig.robot.state() == DeviceState::kEstop);
  rig.fault("robot", FaultKind::kTrip, 0);
  rig.run_for(0.05);  // a status question that is under way refuses the reset
  const Result homed = rig.command("robot", [&](std::int64_t t, Effects& fx) { rig.robot.home(t, fx); });
  INFO(test::describe(homed));
  CHECK(homed.outcome == Outcome::kDone);
}
