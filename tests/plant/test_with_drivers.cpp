// Drivers and twins were written apart, each from the protocol cards: here they meet, byte for byte.
#include <catch2/catch.hpp>

#include <cmath>
#include <functional>
#include <map>

#include "core/grid/firing_order.h"
#include "drivers/jet/jet.h"
#include "drivers/lamp/lamp.h"
#include "drivers/laser_profiler/laser_profiler.h"
#include "drivers/stage/stage.h"
#include "tests/plant/driver_rig.h"

using namespace firn;
using namespace firn::plant;

namespace {

struct Rig : DriverRig {
  explicit Rig(const WorldConfig& config)
      : DriverRig(config, 120'000'000),
        stage(drivers::StageOptions{}),
        jet(drivers::JetOptions{}),
        profiler(drivers::LaserProfilerOptions{}),
        lamp(drivers::LampOptions{}) {
    connect({{kStagePort, &stage}, {kJetPort, &jet}, {kProfilerPort, &profiler}, {kLampPort, &lamp}});
  }
  drivers::Stage stage;
  drivers::Jet jet;
  drivers::LaserProfiler profiler;
  drivers::Lamp lamp;
};

WorldConfig rig_world() {
  WorldConfig c;
  c.grid = {10, 8, 0.263256, 0.263256, 0.0, 0.0};
  c.droplet.missed_probability = 0.0;
  return c;
}

}  // namespace

TEST_CASE("The drivers bring all twins to safe, print a pass, cure it and scan it") {
  Rig rig(rig_world());
  INFO((rig.faults.empty() ? "" : rig.faults.front()));
  REQUIRE(rig.until([&] { return rig.all_safe(); }));
  const GridSpec& grid = rig.world.config().grid;
  DropletPattern pattern(grid);
  for (int j = 1; j < 7; ++j)
    for (int i = 1; i < 9; ++i) pattern.at(i, j) = std::uint8_t((i + j) % 3 != 0);

  CHECK(rig.command(kJetPort, [&](drivers::Driver&,
                                  drivers::Effects& fx) { rig.jet.arm(pattern.total(), rig.now_us, fx); })
            .outcome == Outcome::kReady);
  const auto pass = rig.command(kStagePort, [&](drivers::Driver&, drivers::Effects& fx) {
    rig.stage.run_pass(pattern, 0, 0.0, 50.0, rig.now_us, fx);
  });
  CHECK(pass.outcome == Outcome::kDone);
  CHECK(pass.counted == pattern.total());
  CHECK(rig.command(kJetPort, [&](drivers::Driver&, drivers::Effects& fx) { rig.jet.disarm(rig.now_us, fx); })
            .outcome == Outcome::kDone);
  CHECK(rig.command(kLampPort,
                    [&](drivers::Driver&, drivers::Effects& fx) { rig.lamp.expose(0.5, 80, rig.now_us, fx); })
            .outcome == Outcome::kDone);

  // The truth agrees cell by cell, in firing order.
  const auto order = firing_order(pattern, 0);
  const auto& shots = rig.record.history.shots;
  REQUIRE(shots.size() == order.size());
  for (std::size_t n = 0; n < order.size(); ++n) {
    CHECK(shots[n].outcome == ShotOutcome::kFired);
    CHECK(grid.index(shots[n].i, shots[n].j) == order[n]);
    CHECK(shots[n].x_mm == Approx(grid.x_mm(shots[n].i)).margin(1.01e-4));
  }
  CHECK(rig.world.exposures() == 1);
  CHECK(rig.record.history.lamp.back().dose_s == Approx(0.4).epsilon(0.05));

  CHECK(rig.command(kProfilerPort, [&](drivers::Driver&,
                                       drivers::Effects& fx) { rig.profiler.arm(grid.ny, rig.now_us, fx); })
            .outcome == Outcome::kReady);
  const auto scan = rig.command(kStagePort, [&](drivers::Driver&, drivers::Effects& fx) {
    const double middle_mm = 0.5 * (grid.x_mm(0) + grid.x_mm(grid.nx - 1));
    rig.stage.scan(middle_mm, grid.y_mm(0), 0.0, grid.pitch_y_mm, grid.ny, 5.0, rig.now_us, fx);
  });
  CHECK(scan.outcome == Outcome::kDone);
  CHECK(rig.command(kProfilerPort,
                    [&](drivers::Driver&, drivers::Effects& fx) { rig.profiler.end(rig.now_us, fx); })
            .outcome == Outcome::kDone);
  REQUIRE(rig.all<drivers::ProfileRow>().size() == std::size_t(grid.ny));
  const Truth truth = rig.world.truth();
  for (const drivers::ProfileRow& p : rig.all<drivers::ProfileRow>()) {
    CHECK(rig.record.history.scans[std::size_t(p.row)].y_mm == Approx(grid.y_mm(p.row)).margin(2e-3));
    CHECK(p.encoder_count == std::lround(rig.record.history.scans[std::size_t(p.row)].y_mm * 1e4));
    for (int i = 0; i < grid.nx; ++i) {  // the line through a cell's middle, near its mean
      double sum = 0.0;
      int points = 0;
      for (std::size_t n = 0; n < p.z_mm.size(); ++n)
        if (std::abs(p.x0_mm + double(n) * p.dx_mm - grid.x_mm(i)) < 0.5 * grid.pitch_x_mm &&
            !std::isnan(p.z_mm[n])) {
          sum += p.z_mm[n];
          ++points;
        }
      REQUIRE(points > 20);
      CHECK(std::abs(sum / points - truth.height.at(i, p.row)) < 0.003);
    }
  }
  CHECK(rig.faults.empty());
  for (const DeviceRecord& d : rig.record.history.devices) CHECK(d.event != DeviceEvent::kJetAbused);
}

TEST_CASE("A stop in the middle of a pass silences the stage's pulses within its answer time") {
  Rig rig(rig_world());
  REQUIRE(rig.until([&] { return rig.all_safe(); }));
  DropletPattern pattern(rig.world.config().grid, 1);
  rig.command(kJetPort,
              [&](drivers::Driver&, drivers::Effects& fx) { rig.jet.arm(pattern.total(), rig.now_us, fx); });
  rig.call(kStagePort, [&](drivers::Driver&, drivers::Effects& fx) {
    rig.stage.run_pass(pattern, 0, 0.0, 50.0, rig.now_us, fx);
  });
  REQUIRE(rig.until([&] { return rig.record.history.shots.size() >= 13; }));
  const std::int64_t stop_us = rig.now_us;
  rig.call(kStagePort, [&](drivers::Driver& d, drivers::Effects& fx) { d.safe_stop(rig.now_us, fx); });
  rig.call(kJetPort, [&](drivers::Driver& d, drivers::Effects& fx) { d.safe_stop(rig.now_us, fx); });
  REQUIRE(rig.until([&] { return rig.stage.safe() && rig.jet.safe(); }));
  CHECK(rig.record.history.shots.back().t_us <= stop_us + 1000);
  const drivers::Result& r = rig.results["stage"].back();
  CHECK(r.outcome == Outcome::kFailed);
  CHECK(r.counted == std::int64_t(rig.record.history.shots.size()));
}
