// A stop in the midst of a pass reaches stage and jet at different times: what their answers tell of the
// droplets.
#include <algorithm>
#include <catch2/catch.hpp>
#include <utility>

#include "core/grid/random.h"
#include "tests/drivers/world_rig.h"
#include "tests/drivers/yes_ensemble.h"

using namespace firn;
using namespace firn::drivers;
using firn::drivers::test::WorldRig;
using firn::drivers::test::YesEnsemble;

namespace {

constexpr double kSpeed_mm_s = 20.0;

/// A pass that was stopped: by the stage's counter, by the world's, and until when each of the two worked.
struct Stopped {
  Result stage, jet;
  std::int64_t fired = 0;
};

Stopped stopped_pass(double after_s, double jet_s, double stage_s) {
  WorldRig rig(WorldRig::small_world(12, 6));
  rig.start();
  rig.act("jet", [&](std::int64_t t, Effects& fx) { rig.jet.arm(72, t, fx); });
  REQUIRE(rig.run([&] { return !rig.jet.busy(); }, 30.0));
  DropletPattern full(rig.world.config().grid);
  full.cells.assign(full.size(), 1);
  rig.act("stage",
          [&](std::int64_t t, Effects& fx) { rig.stage.run_pass(full, 0, 1.0, kSpeed_mm_s, t, fx); });
  rig.run_for(after_s);
  const auto stop = [&](std::string_view port) {
    rig.act(port, [&](std::int64_t t, Effects& fx) { rig.driver(port).safe_stop(t, fx); });
  };
  const bool jet_first = jet_s < stage_s;
  rig.run_for(std::min(jet_s, stage_s));
  stop(jet_first ? "jet" : "stage");
  rig.run_for(std::abs(jet_s - stage_s));
  stop(jet_first ? "stage" : "jet");
  REQUIRE(rig.run([&] { return !rig.stage.busy() && rig.jet.safe(); }, 60.0));
  rig.act("jet", [&](std::int64_t t, Effects& fx) { rig.jet.disarm(t, fx); });
  REQUIRE(rig.run([&] { return !rig.jet.busy(); }, 60.0));
  return {rig.results("stage").back(), rig.results("jet").back(), rig.fired()};
}

}  // namespace

TEST_CASE("pulses that the jet did not obey came between the two times that the answers to a stop tell",
          "[jet][stage]") {
  RandomStream random(1, Purpose::kTest);
  const double triggers_per_s = kSpeed_mm_s / WorldRig::small_world(12, 6).grid.pitch_x_mm;
  int lost = 0, none_lost = 0;
  for (int n = 0; n < 60; ++n) {
    const double after_s = 0.2 + 3.0 * random.uniform(), jet_s = 0.1 * random.uniform(),
                 stage_s = 0.3 * random.uniform();
    CAPTURE(after_s, jet_s, stage_s);
    const Stopped s = stopped_pass(after_s, jet_s, stage_s);
    if (s.stage.counted < 0 || s.stage.outcome == Outcome::kUnknown) continue;
    CHECK(s.jet.outcome == Outcome::kDone);
    REQUIRE(s.jet.until_us > 0);
    const std::int64_t disobeyed = s.stage.counted - s.fired;
    REQUIRE(disobeyed >= 0);
    (disobeyed > 0 ? lost : none_lost)++;
    if (s.stage.outcome == Outcome::kDone || disobeyed == 0) continue;
    REQUIRE(s.stage.until_us >= s.jet.until_us);
    CHECK(double(disobeyed) <= 2.0 + 1e-6 * double(s.stage.until_us - s.jet.until_us) * triggers_per_s);
  }
  CHECK(lost > 3);
  CHECK(none_lost > 10);
}

TEST_CASE("a jet that was disarmed at the end of its pass tells no time, whatever stopped before or after",
          "[jet]") {
  WorldRig rig(WorldRig::small_world(12, 6));
  rig.start();
  const auto order = [&](auto f) {
    rig.act("jet", f);
    REQUIRE(rig.run([&] { return !rig.jet.busy() && rig.jet.state() != DeviceState::kStaged; }, 30.0));
    return rig.results("jet").back();
  };
  const auto arm = [&](std::int64_t t, Effects& fx) { rig.jet.arm(72, t, fx); };
  const auto disarm = [&](std::int64_t t, Effects& fx) { rig.jet.disarm(t, fx); };
  const auto stop = [&](std::int64_t t, Effects& fx) { rig.jet.safe_stop(t, fx); };
  CHECK(order(arm).outcome == Outcome::kReady);
  CHECK(order(disarm).until_us == 0);
  rig.act("jet", stop);
  REQUIRE(rig.run([&] { return rig.jet.safe(); }, 30.0));
  CHECK(order(arm).until_us == 0);
  rig.act("jet", stop);
  REQUIRE(rig.run([&] { return rig.jet.safe(); }, 30.0));
  CHECK(order(disarm).until_us > 0);
  CHECK(order(arm).until_us == 0);
  CHECK(order(disarm).until_us == 0);
}

TEST_CASE("a stage whose pulsing axis refuses to switch its trigger off tells the time at which it stood",
          "[stage]") {
  const auto tells = [](const std::string& refused) {
    StageOptions options;
    YesEnsemble e(options);
    DropletPattern row(GridSpec{4, 1, 0.25, 0.25, 0.0, 0.0}, 1);
    e.bench.command([&](auto t, auto& fx) { e.stage.run_pass(row, 0, options.z_min_mm, 0, t, fx); });
    e.run([&] {
      const auto armed = std::ranges::find(e.log, "PSOCONTROL @0 ARM");
      return std::any_of(armed, e.log.end(),
                         [](const std::string& line) { return line.starts_with("LINEAR"); });
    });
    e.refused = refused;
    e.line_us = 1000;
    const auto before = std::ptrdiff_t(e.log.size());
    e.bench.safe_stop();
    e.run([&] { return !e.stage.busy(); });
    const auto y_off = std::find(e.log.begin() + before, e.log.end(), "PSOCONTROL @1 OFF");
    REQUIRE(y_off != e.log.end());
    const std::int64_t y_off_us = e.answered_us[std::size_t(y_off - e.log.begin())];
    REQUIRE(e.bench.now_us > y_off_us);
    const std::int64_t until_us = e.bench.all<Result>().back().until_us;
    return std::pair{until_us == y_off_us, until_us == e.bench.now_us};
  };
  CHECK(tells("").first);
  CHECK(tells("PSOCONTROL @0 OFF").second);
}
