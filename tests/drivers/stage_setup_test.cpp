// The stage's setup before it moves, against its twin: the kind of LINEAR, homing by program,
// the controller's own parameters.
#include <catch2/catch.hpp>

#include "core/grid/random.h"
#include "tests/drivers/bench.h"
#include "tests/drivers/world_rig.h"

using namespace firn;
using namespace firn::drivers;
using firn::drivers::test::WorldRig;
using plant::FaultKind;

namespace {

constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();

enum StageTrip : std::int64_t {
  kMended,
  kEmergency,
  kCounterLost,
  kStuck,
  kEnableRefused,
  kMute,
  kProgramBroken = 8
};

struct StageRig : WorldRig {
  explicit StageRig(const StageOptions& options = fast_stage(),
                    const plant::WorldConfig& config = small_world(6, 4))
      : WorldRig(config, options) {}
  void trip(std::int64_t code) { world.inject({"stage", FaultKind::kTrip, code, 0}, now_us); }
  Result finished(double limit_s = 120.0) {
    REQUIRE(run([&] { return !stage.busy(); }, limit_s));
    return results("stage").back();
  }
  Result move(double x_mm, double y_mm) {
    act("stage", [&](std::int64_t t, Effects& fx) { stage.move_to(x_mm, y_mm, kNoNumber, 0.0, t, fx); });
    return finished();
  }
  std::string stop() const {
    for (const Fault& f : all<Fault>("stage"))
      if (f.severity == Severity::kStop) return std::to_string(f.code) + " " + f.text;
    return {};
  }
};

/// Connects a stage that must not come to SAFE. @returns its stop
std::string refusal(const StageOptions& options, const plant::WorldConfig& config) {
  StageRig rig(options, config);
  rig.world.connect("stage", 0);
  rig.act("stage", [&](std::int64_t t, Effects& fx) { rig.stage.opened(t, fx); });
  rig.run([&] { return !rig.stop().empty(); }, 60.0);
  CHECK(rig.sent("stage", "LINEAR") == 0);
  CHECK(rig.sent("stage", "PROGRAM RUN") + rig.sent("stage", "HOME") == 0);
  return rig.stop();
}

}  // namespace

TEST_CASE(
    "a series of moves ends where it was told, by ABS, and without ABS its second move is noticed as false",
    "[stage]") {
  RandomStream random(3, Purpose::kTest);
  StageRig rig;
  rig.start();
  for (int n = 0; n < 12; ++n) {
    const double x_mm = random.uniform(-40, 140), y_mm = random.uniform(-40, 140);
    if (n % 4 == 3) {  // a stop leaves the controller's mode in doubt
      rig.act("stage", [&](std::int64_t t, Effects& fx) { rig.stage.safe_stop(t, fx); });
      REQUIRE(rig.run([&] { return rig.stage.safe(); }, 10.0));
    }
    REQUIRE(rig.move(x_mm, y_mm).outcome == Outcome::kDone);
    CHECK(rig.stage.position_mm(0) == Approx(x_mm).margin(0.0011));
    CHECK(rig.stage.position_mm(1) == Approx(y_mm).margin(0.0011));
  }
  CHECK(rig.sent("stage", "ABS\n") == 4);

  StageOptions old = WorldRig::fast_stage();
  old.absolute = OnOff::kOff;
  StageRig incremental(old);
  incremental.start();
  CHECK(incremental.move(10, 10).outcome == Outcome::kDone);  // from 0 both are the same
  CHECK(incremental.move(12, 10).outcome == Outcome::kFailed);
  CHECK_THAT(incremental.stop(), Catch::Contains("axis X stands at 22.0000 mm instead of 12.0000 mm"));
}

TEST_CASE("a controller that lost its power is told ABS again before the next move", "[stage]") {
  StageRig rig;
  rig.start();
  REQUIRE(rig.move(10, 10).outcome == Outcome::kDone);
  rig.world.inject({"stage", FaultKind::kReboot, 1, 0}, rig.now_us);
  rig.run_for(2.0);
  REQUIRE(rig.run([&] { return rig.stage.safe(); }, 120.0));
  REQUIRE(rig.move(20, 10).outcome == Outcome::kDone);
  CHECK(rig.stage.position_mm(0) == Approx(20).margin(0.0011));
}

TEST_CASE("the axes home one by one, Z first, by program or by command", "[stage]") {
  for (const Homing homing : {Homing::kProgram, Homing::kCommand}) {
    StageOptions options = WorldRig::fast_stage();
    options.homing = homing;
    StageRig rig(options);
    rig.start();
    const std::string& sent = rig.written["stage"];
    const auto at = [&](int axis) {
      const std::string n = std::to_string(axis);
      return sent.find(homing == Homing::kProgram ? "IGLOBAL(33)=" + n + "\n" : "HOME @" + n + "\n");
    };
    CHECK(at(2) < at(0));
    CHECK(at(0) < at(1));
    CHECK(at(1) != std::string::npos);
    CHECK(rig.sent("stage", "PROGRAM RUN 5, \"HomeAsync.bcx\"") == (homing == Homing::kProgram ? 3 : 0));
    REQUIRE(rig.move(5, 6).outcome == Outcome::kDone);
    rig.act("stage", [&](std::int64_t t, Effects& fx) { rig.stage.home(t, fx); });
    CHECK(rig.finished().outcome == Outcome::kDone);
    CHECK(rig.stage.position_mm(0) == Approx(0).margin(1e-9));
    CHECK(rig.stage.position_mm(1) == Approx(0).margin(1e-9));
  }
}

TEST_CASE("a homing program that ends with an error is named at once, not when its time is over",
          "[stage][corrected:stage-home]") {
  StageRig rig;
  rig.start();
  rig.trip(kProgramBroken);
  const std::int64_t before_us = rig.now_us;
  rig.act("stage", [&](std::int64_t t, Effects& fx) { rig.stage.home(t, fx); });
  CHECK(rig.finished().outcome == Outcome::kFailed);
  CHECK(rig.now_us - before_us < 2'000'000);
  CHECK_THAT(rig.stop(), Catch::Contains("axis Z: the homing program has ended with an error"));
  rig.trip(kMended);
  rig.act("stage", [&](std::int64_t t, Effects& fx) { rig.stage.home(t, fx); });
  CHECK(rig.finished().outcome == Outcome::kDone);
}

TEST_CASE("a stop while the axes home by program stops the program too", "[stage]") {
  StageRig rig;
  rig.start();
  REQUIRE(rig.move(100, 100).outcome == Outcome::kDone);
  rig.act("stage", [&](std::int64_t t, Effects& fx) { rig.stage.home(t, fx); });
  rig.run_for(1.0);
  const int before = rig.sent("stage", "PROGRAM STOP 5");
  rig.act("stage", [&](std::int64_t t, Effects& fx) { rig.stage.safe_stop(t, fx); });
  REQUIRE(rig.run([&] { return rig.stage.safe(); }, 10.0));
  CHECK(rig.sent("stage", "PROGRAM STOP 5") == before + 1);
  CHECK(rig.finished().outcome == Outcome::kFailed);
}

TEST_CASE("a controller whose parameters contradict the lab file moves nothing and is named",
          "[stage][I14][corrected:stage-parameters][corrected:stage-integers]") {
  const auto config = WorldRig::small_world(4, 4);
  auto other = config;
  other.stage.counts_per_mm = 2000;
  CHECK(refusal(WorldRig::fast_stage(), other) ==
        "14 stage: axis X: CountsPerUnit is 2000, stage.counts_per_mm is 10000");
  other = config;
  other.stage.high_limit_mm[1] = 120.0;
  CHECK_THAT(refusal(WorldRig::fast_stage(), other),
             Catch::Contains("14 stage: axis Y: the controller's soft limits [-100, 120] mm are inside "
                             "stage.y_min_mm, stage.y_max_mm [-50, 150] mm"));
  other = config;
  other.stage.global_integers = 50;  // as delivered
  CHECK_THAT(refusal(WorldRig::fast_stage(), other), Catch::Contains("14 stage: GlobalIntegers is 50"));
}

TEST_CASE("I14: a stage that is not homed refuses a move by name, and moves when it is", "[stage][I14]") {
  StageOptions options = WorldRig::fast_stage();
  options.home_at_start = OnOff::kOff;
  StageRig rig(options);
  rig.start();
  const Result refused = rig.move(5, 6);
  CHECK(refused.outcome == Outcome::kRefused);
  CHECK_THAT(refused.text, Catch::Contains("not homed"));
  CHECK(rig.sent("stage", "LINEAR") == 0);
  rig.act("stage", [&](std::int64_t t, Effects& fx) { rig.stage.home(t, fx); });
  REQUIRE(rig.finished().outcome == Outcome::kDone);
  CHECK(rig.move(5, 6).outcome == Outcome::kDone);
}

TEST_CASE("a row is split by the global integers that the controller really has",
          "[stage][corrected:stage-integers]") {
  auto config = WorldRig::small_world(17, 3);
  config.stage.global_integers = 54;
  StageRig rig(WorldRig::fast_stage(), config);
  rig.start();
  DropletPattern pattern(config.grid);
  std::fill(pattern.cells.begin(), pattern.cells.end(), std::uint8_t(1));
  rig.act("stage",
          [&](std::int64_t t, Effects& fx) { rig.stage.run_pass(pattern, 0, kNoNumber, 0.0, t, fx); });
  CHECK(rig.finished().counted == 51);
  CHECK(rig.sent("stage", "IGLOBAL(54)") == 0);
  CHECK(rig.sent("stage", " ARM\n") == 3 * 5);
}

TEST_CASE("an axis that is stuck, one that does not enable and pulses that are not put out are named",
          "[stage][I5]") {
  {
    StageRig rig;
    rig.start();
    rig.trip(kStuck);
    CHECK(rig.move(30, 30).outcome == Outcome::kFailed);
    CHECK_THAT(rig.stop(), Catch::StartsWith("5 ") && Catch::Contains("axis X"));
    rig.run_for(1.0);
    CHECK(rig.stage.state() == DeviceState::kFault);
  }
  {
    StageRig rig;
    rig.trip(kEnableRefused);
    rig.world.connect("stage", 0);
    rig.act("stage", [&](std::int64_t t, Effects& fx) { rig.stage.opened(t, fx); });
    REQUIRE(rig.run([&] { return !rig.stop().empty(); }, 60.0));
    CHECK_THAT(rig.stop(), Catch::Contains("cannot do 'ENABLE @0'"));
  }
  {
    StageRig rig;
    rig.start();
    DropletPattern pattern(rig.world.config().grid);
    std::fill(pattern.cells.begin(), pattern.cells.end(), std::uint8_t(1));
    rig.trip(kMute);
    rig.act("stage",
            [&](std::int64_t t, Effects& fx) { rig.stage.run_pass(pattern, 0, kNoNumber, 0.0, t, fx); });
    const Result r = rig.finished();
    CHECK(r.outcome != Outcome::kDone);
    CHECK(r.code == kPulseCount);
    CHECK_THAT(rig.stop(), Catch::Contains("0 pulses counted, 6 commanded"));
  }
}

TEST_CASE("without a pulse counter a whole row counts by its end, and a broken one is in doubt", "[stage]") {
  StageOptions options = WorldRig::fast_stage();
  options.pulse_count = PulseCounter::kNone;
  StageRig rig(options);
  rig.start();
  DropletPattern pattern(rig.world.config().grid);
  std::fill(pattern.cells.begin(), pattern.cells.end(), std::uint8_t(1));
  rig.act("stage",
          [&](std::int64_t t, Effects& fx) { rig.stage.run_pass(pattern, 0, kNoNumber, 0.0, t, fx); });
  CHECK(rig.finished().counted == 24);
  rig.act("stage",
          [&](std::int64_t t, Effects& fx) { rig.stage.run_pass(pattern, 0, kNoNumber, 0.0, t, fx); });
  REQUIRE(rig.run([&] { return rig.stage.progress().run == 2 && rig.stage.progress().launched; }, 60.0));
  rig.act("stage", [&](std::int64_t t, Effects& fx) { rig.stage.safe_stop(t, fx); });
  const Result r = rig.finished();
  CHECK(r.outcome == Outcome::kUnknown);
  CHECK(r.unknown_from == 12);
  CHECK(r.unknown_to == 18);
  CHECK(rig.sent("stage", "PSOCOUNT") == 0);
}

TEST_CASE("I5: without a pulse counter a row whose axis stuck is in doubt, and never done", "[stage][I5]") {
  StageOptions options = WorldRig::fast_stage();
  options.pulse_count = PulseCounter::kNone;
  for (const int row : {0, 1, 3}) {
    StageRig rig(options);
    rig.start();
    DropletPattern pattern(rig.world.config().grid);
    std::fill(pattern.cells.begin(), pattern.cells.end(), std::uint8_t(1));
    rig.act("stage",
            [&](std::int64_t t, Effects& fx) { rig.stage.run_pass(pattern, 0, kNoNumber, 0.0, t, fx); });
    REQUIRE(
        rig.run([&] { return int(rig.stage.progress().run) == row && rig.stage.progress().launched; }, 60.0));
    rig.trip(kStuck);
    const Result r = rig.finished();
    INFO(test::describe(r));
    CHECK(r.outcome == Outcome::kUnknown);
    CHECK(r.unknown_from == 6 * row);
    CHECK(r.unknown_to == 6 * (row + 1));
    CHECK_THAT(rig.stop(), Catch::StartsWith("5 ") && Catch::Contains("axis X"));
    const auto fired = std::int64_t(rig.record.history.shots.size());
    CHECK(fired >= r.unknown_from);
    CHECK(fired <= r.unknown_to);
  }
}
