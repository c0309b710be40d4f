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
#include "tests/plant/bench_lines.h"

using namespace firn;
using namespace firn::plant;
using drivers::DriverState;
using drivers::Outcome;

namespace {

struct Rig {
  explicit Rig(const WorldConfig& config)
      : world(config, &record),
        stage(drivers::StageConfig{}),
        jet(drivers::JetConfig{}),
        profiler(drivers::LaserProfilerConfig{}),
        lamp(drivers::LampConfig{}),
        parts{{kStagePort, {&stage, 0}},
              {kJetPort, {&jet, 0}},
              {kProfilerPort, {&profiler, 0}},
              {kLampPort, {&lamp, 0}}} {
    for (auto& [port, part] : parts) {
      world.connect(port, now_us);
      call(port, [&](drivers::Driver& driver, drivers::Effects& fx) { driver.opened(now_us, fx); });
    }
  }
  using Step = std::function<void(drivers::Driver&, drivers::Effects&)>;
  void call(std::string_view port, const Step& f) {
    drivers::Effects fx;
    auto& part = parts.at(port);
    f(*part.driver, fx);
    part.wake_us = fx.wake_us;
    for (auto& e : fx.events) {
      if (auto* r = std::get_if<drivers::Result>(&e)) results[std::string(port)].push_back(*r);
      if (auto* p = std::get_if<drivers::Profile>(&e)) profiles.push_back(*p);
      if (auto* x = std::get_if<drivers::Fault>(&e)) faults.push_back(std::string(port) + ": " + x->text);
    }
    if (!fx.tx.empty()) world.receive(port, fx.tx, now_us);
    if (!fx.reopen) return;
    world.disconnect(port, now_us);
    world.connect(port, now_us);
    call(port, [&](drivers::Driver& driver, drivers::Effects& again) { driver.closed(now_us, again); });
    call(port, [&](drivers::Driver& driver, drivers::Effects& again) { driver.opened(now_us, again); });
  }
  /// Steps until `done` or for at most `limit_us`.
  bool until(const std::function<bool()>& done, std::int64_t limit_us = 120'000'000) {
    const std::int64_t end_us = now_us + limit_us;
    while (!done() && now_us < end_us) {
      std::int64_t next_us = std::min(world.next_event_us(), end_us);
      for (const auto& [port, part] : parts)
        if (part.wake_us != 0) next_us = std::min(next_us, std::max(part.wake_us, now_us));
      now_us = next_us;
      std::vector<std::pair<std::string_view, std::vector<std::byte>>> due;
      world.advance(now_us, [&](const World::Sent& s) {
        due.push_back({s.port, {s.bytes.begin(), s.bytes.end()}});
      });
      for (const auto& [port, bytes] : due)
        call(port,
             [&](drivers::Driver& driver, drivers::Effects& fx) { driver.received(bytes, now_us, fx); });
      for (auto& [port, part] : parts)
        if (part.wake_us != 0 && part.wake_us <= now_us) {
          part.wake_us = 0;
          call(port, [&](drivers::Driver& driver, drivers::Effects& fx) { driver.woke(now_us, fx); });
        }
    }
    return done();
  }
  bool all_safe() const {
    for (const auto& [port, part] : parts)
      if (part.driver->state() != DriverState::kSafe) return false;
    return true;
  }
  /// Runs a command and returns its result.
  drivers::Result command(std::string_view port, const Step& f) {
    auto& list = results[std::string(port)];
    const std::size_t before = list.size();
    call(port, f);
    REQUIRE(until([&] { return list.size() > before; }));
    return list.back();
  }

  struct Part {
    drivers::Driver* driver;
    std::int64_t wake_us;
  };
  MemoryRecord record;
  World world;
  std::int64_t now_us = 0;
  drivers::Stage stage;
  drivers::Jet jet;
  drivers::LaserProfiler profiler;
  drivers::Lamp lamp;
  std::map<std::string_view, Part> parts;
  std::map<std::string, std::vector<drivers::Result>> results;
  std::vector<drivers::Profile> profiles;
  std::vector<std::string> faults;
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
    rig.stage.scan(1.0, grid.y_mm(0), 0.0, grid.pitch_y_mm, grid.ny, 5.0, rig.now_us, fx);
  });
  CHECK(scan.outcome == Outcome::kDone);
  CHECK(rig.command(kProfilerPort,
                    [&](drivers::Driver&, drivers::Effects& fx) { rig.profiler.end(rig.now_us, fx); })
            .outcome == Outcome::kDone);
  REQUIRE(rig.profiles.size() == std::size_t(grid.ny));
  const Truth truth = rig.world.truth();
  for (const drivers::Profile& p : rig.profiles) {
    CHECK(rig.record.history.scans[std::size_t(p.row)].y_mm == Approx(grid.y_mm(p.row)).margin(2e-3));
    CHECK(p.encoder_count == std::lround(rig.record.history.scans[std::size_t(p.row)].y_mm * 1e4));
    for (int i = 0; i < grid.nx; ++i) {  // the line through a cell's middle, near its mean
      double sum = 0.0;
      int points = 0;
      for (std::size_t n = 0; n < p.z_mm.size(); ++n)
        if (std::abs(p.x0_mm + double(n) * p.dx_mm - grid.x_mm(i)) < 0.5 * grid.pitch_x_mm &&
            !std::isnan(p.z_mm[n]))
          sum += p.z_mm[n], ++points;
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
