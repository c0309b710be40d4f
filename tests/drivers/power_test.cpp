// Instruments that lose their power, are disarmed or never arm during a pass, against the twins of the
// simulated world.
#include <catch2/catch.hpp>

#include "core/grid/firing_order.h"
#include "tests/drivers/bench.h"
#include "tests/drivers/lossy_line.h"
#include "tests/drivers/world_rig.h"

using namespace firn;
using namespace firn::drivers;
using firn::drivers::test::next;
using firn::drivers::test::WorldRig;
using plant::FaultKind;

namespace {

DropletPattern full(const GridSpec& grid) {
  DropletPattern p(grid);
  p.cells.assign(p.size(), 1);
  return p;
}

void fault(WorldRig& rig, const char* port, FaultKind kind, std::int64_t count = 1) {
  rig.world.inject({port, kind, count, 0}, rig.now_us);
}

Result arm(WorldRig& rig) {
  rig.act("jet", [&](std::int64_t t, Effects& fx) { rig.jet.arm(72, t, fx); });
  REQUIRE(rig.run([&] { return !rig.jet.busy(); }, 30.0));
  return rig.results("jet").back();
}

Result disarm(WorldRig& rig) {
  REQUIRE(rig.run([&] { return rig.jet.state() == DeviceState::kArmed || rig.jet.safe(); }, 60.0));
  rig.act("jet", [&](std::int64_t t, Effects& fx) { rig.jet.disarm(t, fx); });
  REQUIRE(rig.run([&] { return !rig.jet.busy() && rig.jet.safe(); }, 60.0));
  return rig.results("jet").back();
}

/// A pass in which `kind` happens to the jet after `after_s`. @returns the answer to its disarming
Result pass_with(FaultKind kind, std::int64_t count, double after_s) {
  WorldRig rig(WorldRig::small_world(12, 6));
  rig.start();
  REQUIRE(arm(rig).outcome == Outcome::kReady);
  rig.act("stage", [&](std::int64_t t, Effects& fx) {
    rig.stage.run_pass(full(rig.world.config().grid), 0, 1.0, 0.0, t, fx);
  });
  rig.run_for(after_s);
  fault(rig, "jet", kind, count);
  REQUIRE(rig.run([&] { return !rig.stage.busy(); }, 60.0));
  CHECK(rig.results("stage").back().outcome == Outcome::kDone);
  return disarm(rig);
}

}  // namespace

TEST_CASE("a jet that lost its power during a pass leaves all of it in doubt, its port closed or not",
          "[power]") {
  std::uint64_t seed = 5;
  for (const FaultKind kind : {FaultKind::kReboot, FaultKind::kPower})
    for (int round = 0; round < 6; ++round) {
      const Result r = pass_with(kind, 1, double(next(seed) % 600) * 1e-3);
      INFO(int(kind) << " " << test::describe(r));
      CHECK(r.outcome == Outcome::kUnknown);
      CHECK(r.unknown_to == 72);
    }
}

TEST_CASE("a jet that was disarmed at its panel during a pass leaves all of it in doubt", "[power]") {
  std::uint64_t seed = 6;
  for (int round = 0; round < 6; ++round) {
    const Result r = pass_with(FaultKind::kTrip, 1, double(next(seed) % 600) * 1e-3);
    CHECK(r.outcome == Outcome::kUnknown);
    CHECK(r.code == kInstrument);
    CHECK_THAT(r.text, Catch::Contains("not armed any more"));
  }
}

TEST_CASE("a stage that lost its pulse counter and kept its homing never calls a fired droplet unfired",
          "[power]") {
  std::uint64_t seed = 11;
  int doubts = 0;
  for (int round = 0; round < 60; ++round) {
    WorldRig rig(WorldRig::small_world(12, 6));
    rig.start();
    REQUIRE(arm(rig).outcome == Outcome::kReady);
    rig.act("stage", [&](std::int64_t t, Effects& fx) {
      rig.stage.run_pass(full(rig.world.config().grid), 0, 1.0, 0.0, t, fx);
    });
    const double lost_s = double(next(seed) % 900) * 1e-3, then_s = double(next(seed) % 60) * 1e-3;
    rig.run_for(lost_s);
    fault(rig, "stage", FaultKind::kTrip, 2);
    rig.run_for(then_s);
    if (round % 2 == 0) rig.act("stage", [&](std::int64_t t, Effects& fx) { rig.stage.safe_stop(t, fx); });
    REQUIRE(rig.run([&] { return !rig.stage.busy(); }, 60.0));
    const Result r = rig.results("stage").back();
    INFO("round " << round << ", counter lost after " << lost_s << " s: " << test::describe(r));
    const std::int64_t fired = rig.fired();
    CHECK(r.unknown_to >= fired);
    CHECK((r.outcome == Outcome::kUnknown ? r.unknown_from : r.counted) <= fired);
    doubts += r.outcome == Outcome::kUnknown;
  }
  CHECK(doubts > 10);
}

TEST_CASE("a jet that was armed during all of a pass is in no doubt", "[power]") {
  CHECK(pass_with(FaultKind::kTrip, 0, 0.3).outcome == Outcome::kDone);
}

TEST_CASE("a jet whose driver died and came back during a pass is in no doubt when it is still armed",
          "[power]") {
  for (const bool reset : {false, true}) {
    WorldRig rig(WorldRig::small_world(12, 6));
    rig.start();
    REQUIRE(arm(rig).outcome == Outcome::kReady);
    rig.kill("jet");
    if (reset) fault(rig, "jet", FaultKind::kPower);
    rig.run_for(0.5);
    rig.resume("jet");
    CHECK(disarm(rig).outcome == (reset ? Outcome::kUnknown : Outcome::kDone));
  }
}

TEST_CASE("a jet that lost its power while its driver was dead is safe soon after, and stops nothing again",
          "[power]") {
  std::uint64_t seed = 12;
  for (int round = 0; round < 30; ++round) {
    WorldRig rig(WorldRig::small_world(12, 6));
    rig.start();
    rig.act("jet", [&](std::int64_t t, Effects& fx) { rig.jet.arm(72, t, fx); });
    rig.run_for(double(next(seed) % 40) * 1e-3);
    if (round % 3 == 0) rig.act("jet", [&](std::int64_t t, Effects& fx) { rig.jet.safe_stop(t, fx); });
    rig.kill("jet");
    fault(rig, "jet", FaultKind::kPower);
    rig.run_for(0.5);
    rig.resume("jet");
    const std::size_t before = rig.all<Fault>("jet").size();
    const std::int64_t since_us = rig.now_us;
    INFO("round " << round);
    REQUIRE(rig.run([&] { return rig.jet.safe(); }, 120.0));
    CHECK(rig.now_us - since_us < 20'000'000);
    const std::vector<Fault> faults = rig.all<Fault>("jet");
    for (std::size_t n = before; n < faults.size(); ++n) {
      INFO(faults[n].text);
      CHECK(faults[n].severity != Severity::kStop);
    }
  }
}

TEST_CASE("a jet that acknowledges its arming and is not armed is named before the pass begins", "[power]") {
  WorldRig rig(WorldRig::small_world(12, 6));
  rig.start();
  fault(rig, "jet", FaultKind::kTrip, 2);
  const Result r = arm(rig);
  CHECK(r.outcome == Outcome::kNone);
  CHECK(r.code == kInstrument);
  CHECK_THAT(r.text, Catch::Contains("not armed"));
  REQUIRE(rig.run([&] { return rig.jet.safe(); }, 10.0));
  fault(rig, "jet", FaultKind::kTrip, 0);
  CHECK(arm(rig).outcome == Outcome::kReady);
}

TEST_CASE("the doubt about a pass is told again when it is asked for again, and ends with the next arming",
          "[power]") {
  WorldRig rig(WorldRig::small_world(12, 6));
  rig.start();
  REQUIRE(arm(rig).outcome == Outcome::kReady);
  fault(rig, "jet", FaultKind::kPower);
  CHECK(disarm(rig).outcome == Outcome::kUnknown);
  rig.kill("jet");
  rig.run_for(0.5);
  rig.resume("jet");
  CHECK(disarm(rig).outcome == Outcome::kUnknown);
  REQUIRE(arm(rig).outcome == Outcome::kReady);
  CHECK(disarm(rig).outcome == Outcome::kDone);
}

TEST_CASE("after any instrument of the ink-jet lab lost its power the stage homes again before it moves",
          "[power]") {
  WorldRig rig(WorldRig::small_world(6, 4));
  rig.start();
  for (const auto* port : {"stage", "jet", "laser_profiler", "lamp"}) fault(rig, port, FaultKind::kPower);
  const int homed = rig.sent("stage", "PROGRAM RUN");
  rig.act("stage", [&](std::int64_t t, Effects& fx) {
    rig.stage.run_pass(full(rig.world.config().grid), 0, 1.0, 0.0, t, fx);
  });
  REQUIRE(rig.run([&] { return !rig.stage.busy(); }, 120.0));
  REQUIRE(rig.run([&] { return rig.all_safe(); }, 120.0));
  CHECK(rig.record.history.shots.empty());
  rig.act("stage", [&](std::int64_t t, Effects& fx) { rig.stage.move_to(1.0, 1.0, 1.0, 0.0, t, fx); });
  REQUIRE(rig.run([&] { return !rig.stage.busy(); }, 120.0));
  CHECK(rig.results("stage").back().outcome == Outcome::kDone);
  CHECK(rig.sent("stage", "PROGRAM RUN") >= homed + 3);
}

TEST_CASE("an answer to a question asked before the arming or the disarming puts no pass in doubt",
          "[power]") {
  WorldRig rig(WorldRig::small_world(12, 6));
  rig.start();
  std::uint64_t seed = 8;
  const double idle_s = JetOptions{}.poll_idle_s - 0.02;
  for (int round = 0; round < 200;
       ++round) {  // an idle jet is polled again and again: some answers are under way
    rig.run_for(idle_s + double(next(seed) % 400) * 1e-4);
    const Result armed = arm(rig);
    INFO(round << " " << test::describe(armed));
    REQUIRE(armed.outcome == Outcome::kReady);
    rig.run_for(idle_s + double(next(seed) % 400) * 1e-4);
    const Result done = disarm(rig);
    INFO(test::describe(done));
    REQUIRE(done.outcome == Outcome::kDone);
  }
}

namespace {

const std::string kResetFrame = "\x53\x02\x01\x03";

/// Seconds from the end of `kind` until the jet is safe again, and what it was told meanwhile.
std::pair<double, std::string> back_after(FaultKind kind) {
  WorldRig rig(WorldRig::small_world(4, 4));
  rig.start();
  const std::size_t before = rig.written["jet"].size();
  fault(rig, "jet", kind);
  REQUIRE(rig.run([&] { return !rig.jet.safe(); }, 10.0));
  const std::int64_t lost_us = rig.now_us;
  REQUIRE(rig.run([&] { return rig.jet.safe(); }, 30.0));
  return {double(rig.now_us - lost_us) * 1e-6, rig.written["jet"].substr(before)};
}

}  // namespace

TEST_CASE("a jet that kept its power is set up again without a start of its firmware", "[power]") {
  const auto [took_s, told] = back_after(FaultKind::kClose);
  CHECK(took_s < 1.5);
  CHECK(told.find("X2000") == std::string::npos);
  CHECK(told.find(kResetFrame) == std::string::npos);
  CHECK(told.find("\x53\x03\x08") < told.find("\x53\x15\x06"));  // SOURCE 0, then the waveform
}

TEST_CASE("a jet that lost its power is started anew, with RESET", "[power]") {
  const auto [took_s, told] = back_after(FaultKind::kReboot);
  CHECK(took_s < 8.0);  // of which its boot, RESET and PULSE take 4.6
  CHECK(told.find("X2000") < told.find(kResetFrame));
  CHECK(told.find(kResetFrame) != std::string::npos);
}

TEST_CASE("a jet is told its waveform again after every lost link", "[power]") {
  WorldRig rig(WorldRig::small_world(4, 4));
  rig.start();
  const std::size_t before = rig.written["jet"].size();
  rig.unplug("jet");
  REQUIRE(rig.run([&] { return rig.jet.safe(); }, 30.0));
  CHECK(rig.written["jet"].find("\x53\x15\x06", before) != std::string::npos);
  CHECK(arm(rig).outcome == Outcome::kReady);
}
