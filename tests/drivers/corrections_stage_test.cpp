// Rows of the stage in corrections_test.cpp: the bytes that the driver sent before, against the corrected
// twin, and today's driver against the same twin. Apart from its own row the old host is as corrected, so
// that each row fails alone.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "tests/drivers/world_rig.h"
#include "tests/plant/bench_lines.h"

using namespace firn;
using namespace firn::drivers;
using firn::drivers::test::WorldRig;

namespace {

constexpr double kNoHeight = std::numeric_limits<double>::quiet_NaN();
constexpr int kDroplets = 12;
constexpr double kPitch_mm = 0.25, kRunUp_mm = 1.1, kCounts_mm = 10'000.0;  // at 100 mm/s and 5000 mm/s^2

/// The old driver's lines at a connection, for a move and for a row of droplets from x = 0 on.
struct OldHost {
  plant::Bench bench;
  std::string refused;  ///< the first line that was not obeyed

  OldHost(const plant::WorldConfig& config, bool absolute) : bench(config) {
    plant::start_jet(bench);
    plant::arm_jet(bench);
    for (const char* line : {"WAIT MODE NOWAIT", "PSOCONTROL @0 OFF", "PSOCONTROL @1 OFF", "ABORT @0",
                             "ABORT @1", "ABORT @2", "ENABLE @0", "ENABLE @1", "ENABLE @2",
                             "RAMP MODE @0 RATE", "RAMP MODE @1 RATE", "RAMP MODE @2 RATE", "RAMP RATE 5000"})
      say(line);
    if (absolute) say("ABS");
  }
  std::string say(const std::string& line) {
    std::string answer = bench.stage(line);
    if (!answer.starts_with("%") && refused.empty()) refused = line;
    return answer;
  }
  void go(const std::string& line) {
    say(line);
    while (say("PLANESTATUS(0)") == "%1\n") bench.run(2000);
  }
  double at_mm(int axis) { return std::stod(say("PFBKPROG(@" + std::to_string(axis) + ")").substr(1)); }
  /// @returns its reading of PSOCOUNT
  std::string row() {
    go("LINEAR @0 -1.1 @1 0 F150");
    for (const char* line :
         {"PSOCONTROL @0 RESET", "PSOOUTPUT @0 PULSE", "PSOPULSE @0 TIME 50,25", "PSOTRACK @0 INPUT 0"})
      say(line);
    for (int n = 0; n < kDroplets; ++n)
      say("IGLOBAL(" + std::to_string(50 + n) +
          ")=" + std::to_string(std::lround((n == 0 ? kRunUp_mm : kPitch_mm) * kCounts_mm)));
    say("PSOARRAY @0,50," + std::to_string(kDroplets));
    say("PSODISTANCE @0 ARRAY");
    say("PSOCONTROL @0 ARM");
    go("LINEAR @0 " + std::to_string((kDroplets - 1) * kPitch_mm + kRunUp_mm) + " F100");
    say("PSOCONTROL @0 OFF");
    return say("PSOCOUNT(@0)");
  }
  const std::vector<plant::ShotRecord>& shots() const { return bench.record.history.shots; }
};

plant::WorldConfig row_world() {
  plant::WorldConfig c = WorldRig::small_world(kDroplets, 1);
  c.grid.pitch_x_mm = c.grid.pitch_y_mm = kPitch_mm;
  return c;
}

/// Today's driver, which prints the same row.
struct Today : WorldRig {
  Result result;
  Today(const plant::WorldConfig& config, const StageOptions& options) : WorldRig(config, options) {
    start();
    act("jet", [&](std::int64_t t, Effects& fx) { jet.arm(kDroplets, t, fx); });
    REQUIRE(run([&] { return !jet.busy(); }, 10.0));
    DropletPattern pattern(config.grid);
    std::ranges::fill(pattern.cells, std::uint8_t(1));
    act("stage", [&](std::int64_t t, Effects& fx) { stage.run_pass(pattern, 0, kNoHeight, 0.0, t, fx); });
    REQUIRE(run([&] { return !stage.busy(); }, 60.0));
    result = results("stage").back();
  }
};

/// Speed from one droplet to the next [mm/s].
double speed_mm_s(const std::vector<plant::ShotRecord>& shots, std::size_t n) {
  return (shots[n + 1].x_mm - shots[n].x_mm) / (double(shots[n + 1].t_us - shots[n].t_us) * 1e-6);
}

}  // namespace

TEST_CASE("without ABS the old host's second move ends beside its target, and today's on it",
          "[stage][corrected:stage-absolute]") {
  OldHost old(row_world(), false);
  old.go("LINEAR @0 10 @1 10 F150");
  old.go("LINEAR @0 12 @1 10 F150");
  CHECK(old.refused.empty());
  CHECK(old.at_mm(0) == Approx(22.0));
  CHECK(old.at_mm(1) == Approx(20.0));

  WorldRig rig(row_world());
  rig.start();
  for (const double x_mm : {10.0, 12.0}) {
    rig.act("stage",
            [&](std::int64_t t, Effects& fx) { rig.stage.move_to(x_mm, 10, kNoHeight, 0.0, t, fx); });
    REQUIRE(rig.run([&] { return !rig.stage.busy(); }, 60.0));
  }
  CHECK(rig.stage.position_mm(0) == Approx(12.0).margin(0.0011));
}

TEST_CASE("HOME keeps some firmware busy, and the old host's stop is not obeyed, today's is at once",
          "[stage][corrected:stage-home]") {
  plant::WorldConfig config = row_world();
  config.stage.home_blocks = true;
  OldHost old(config, true);
  old.go("LINEAR @0 100 F150");
  old.bench.send(plant::kStagePort, "HOME @0\n");
  old.bench.run(1'000'000);
  CHECK(
      old.bench.ask(plant::kStagePort, "PSOCONTROL @0 OFF\nABORT @0\nABORT @1\nABORT @2\n", 500'000).empty());
  old.bench.run(5'000'000);
  CHECK(old.at_mm(0) == 0.0);

  WorldRig rig(config);
  rig.start();
  rig.act("stage", [&](std::int64_t t, Effects& fx) { rig.stage.move_to(100, 0, kNoHeight, 0.0, t, fx); });
  REQUIRE(rig.run([&] { return !rig.stage.busy(); }, 60.0));
  rig.act("stage", [&](std::int64_t t, Effects& fx) { rig.stage.home(t, fx); });
  REQUIRE(rig.run([&] { return rig.sent("stage", "IGLOBAL(33)=0\n") == 2; }, 20.0));
  rig.run_for(1.0);
  rig.act("stage", [&](std::int64_t t, Effects& fx) { rig.stage.safe_stop(t, fx); });
  REQUIRE(rig.run([&] { return rig.stage.safe(); }, 1.0));
  CHECK(rig.stage.position_mm(0) > 70.0);
}

TEST_CASE("a controller as delivered has no global integer for the old host's firing distances",
          "[stage][corrected:stage-integers]") {  // today's names GlobalIntegers: stage_setup_test.cpp
  plant::WorldConfig config = row_world();
  config.stage.global_integers = 50;
  OldHost old(config, true);
  CHECK(old.row() == "%0\n");
  CHECK(old.refused == "IGLOBAL(50)=11000");
  CHECK(old.shots().empty());
}

TEST_CASE("a controller with other counts puts the old host's droplets elsewhere, and nothing says so",
          "[stage][corrected:stage-parameters]") {  // today's names CountsPerUnit: stage_setup_test.cpp
  plant::WorldConfig config = row_world();
  config.stage.counts_per_mm = 2 * kCounts_mm;
  OldHost old(config, true);
  CHECK(old.row() == "%" + std::to_string(kDroplets) + "\n");
  CHECK(old.refused.empty());
  REQUIRE(int(old.shots().size()) == kDroplets);
  CHECK(old.shots()[0].x_mm == Approx(0.5 * kRunUp_mm - kRunUp_mm).margin(1e-3));
  CHECK(old.shots()[1].x_mm - old.shots()[0].x_mm == Approx(0.5 * kPitch_mm).margin(1e-3));
}

TEST_CASE("under an S-shaped ramp the old host's first droplets fall at a changing speed, and today's do not",
          "[stage][corrected:stage-ramps]") {
  plant::WorldConfig config = row_world();
  config.stage.scurve_percent = 100.0;
  OldHost old(config, true);
  old.row();
  REQUIRE(int(old.shots().size()) == kDroplets);
  CHECK(speed_mm_s(old.shots(), 0) < 0.85 * speed_mm_s(old.shots(), kDroplets / 2));

  const Today today(config, WorldRig::fast_stage());
  CHECK(today.result.outcome == Outcome::kDone);
  const auto& shots = today.record.history.shots;
  REQUIRE(int(shots.size()) == kDroplets);
  for (std::size_t n = 0; n + 1 < shots.size(); ++n)
    CHECK(speed_mm_s(shots, n) == Approx(100.0).epsilon(0.01));
}

TEST_CASE("pulses that are sent to no terminal are counted, and the old host's row has no droplet",
          "[stage][corrected:stage-terminal]") {
  plant::WorldConfig config = row_world();
  config.stage.terminal_needed = true;
  OldHost old(config, true);
  CHECK(old.row() == "%" + std::to_string(kDroplets) + "\n");
  CHECK(old.refused.empty());
  CHECK(old.shots().empty());

  const Today today(config, WorldRig::fast_stage());
  CHECK(today.result.outcome == Outcome::kDone);
  CHECK(int(today.record.history.shots.size()) == kDroplets);
}

TEST_CASE(
    "a controller without PSOCOUNT leaves the old host's rows in doubt, and today's asks as its lab file "
    "says",
    "[stage][corrected:stage-counter]") {
  for (const PulseCounter question : {PulseCounter::kNone, PulseCounter::kPsostatus}) {
    plant::WorldConfig config = row_world();
    config.stage.pulse_counter = question == PulseCounter::kNone ? "" : "PSOSTATUS";
    OldHost old(config, true);
    CHECK(old.row() == "!\n");
    CHECK(old.refused == "PSOCOUNT(@0)");
    CHECK(int(old.shots().size()) == kDroplets);

    StageOptions options = WorldRig::fast_stage();
    options.pulse_count = question;
    const Today today(config, options);
    CHECK(today.result.outcome == Outcome::kDone);
    CHECK(today.result.counted == kDroplets);
  }
}
