// Drivers against the twins of the simulated world: every command happens as commanded, and the answer about
// an interrupted pass is the truth.
#include <catch2/catch.hpp>
#include <cmath>

#include "core/grid/firing_order.h"
#include "core/grid/random.h"
#include "tests/drivers/bench.h"
#include "tests/drivers/lossy_line.h"
#include "tests/drivers/world_rig.h"

using namespace firn;
using namespace firn::drivers;
using firn::drivers::test::next;
using firn::drivers::test::WorldRig;

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

DropletPattern random_pattern(const GridSpec& grid, std::uint64_t seed) {
  DropletPattern p(grid);
  for (auto& c : p.cells) c = std::uint8_t(next(seed) % 3);
  return p;
}

void arm_jet(WorldRig& rig, std::int64_t expected) {
  rig.act("jet", [&](std::int64_t t, Effects& fx) { rig.jet.arm(expected, t, fx); });
  REQUIRE(rig.run([&] { return !rig.jet.busy(); }, 5.0));
  REQUIRE(rig.jet.state() == DeviceState::kArmed);
}

void begin_pass(WorldRig& rig, const DropletPattern& pattern, int pass) {
  rig.act("stage", [&](std::int64_t t, Effects& fx) { rig.stage.run_pass(pattern, pass, 1.0, 0.0, t, fx); });
}

// Every shot, in order, at the cell that the firing order names, on its grid point.
void check_shots(const WorldRig& rig, const std::vector<std::uint32_t>& order, std::size_t from,
                 std::size_t count, const GridSpec& grid) {
  const auto& shots = rig.record.history.shots;
  REQUIRE(shots.size() >= from + count);
  for (std::size_t n = 0; n < count; ++n) {
    const auto& shot = shots[from + n];
    const int i = int(order[n] % std::uint32_t(grid.nx)), j = int(order[n] / std::uint32_t(grid.nx));
    CHECK(shot.outcome == plant::ShotOutcome::kFired);
    CHECK(std::abs(shot.x_mm - grid.x_mm(i)) < 0.0005);
    CHECK(std::abs(shot.y_mm - grid.y_mm(j)) < 0.0005);
  }
}

}  // namespace

TEST_CASE("every pass fires each droplet once, in the firing order, on its grid point", "[world]") {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    WorldRig rig(WorldRig::small_world(12, 7));
    rig.start();
    const GridSpec grid = rig.world.config().grid;
    const DropletPattern pattern = random_pattern(grid, seed);
    std::size_t before = 0;
    for (int pass = 0; pass < pattern.passes(); ++pass) {
      const auto order = firing_order(pattern, pass);
      arm_jet(rig, std::int64_t(order.size()));
      begin_pass(rig, pattern, pass);
      REQUIRE(rig.run([&] { return !rig.stage.busy(); }, 60.0));
      const Result r = rig.results("stage").back();
      CHECK(r.outcome == Outcome::kDone);
      CHECK(r.counted == std::int64_t(order.size()));
      rig.act("jet", [&](std::int64_t t, Effects& fx) { rig.jet.disarm(t, fx); });
      REQUIRE(rig.run([&] { return rig.jet.safe(); }, 5.0));
      check_shots(rig, order, before, order.size(), grid);
      before += order.size();
      CHECK(rig.record.history.shots.size() == before);
    }
  }
}

TEST_CASE("rows with more droplets than the controller's array are split and lose none", "[world]") {
  StageOptions config = WorldRig::fast_stage();
  config.array_limit = 5;
  WorldRig rig(WorldRig::small_world(17, 3), config);
  rig.start();
  const GridSpec grid = rig.world.config().grid;
  DropletPattern pattern(grid);
  std::fill(pattern.cells.begin(), pattern.cells.end(), std::uint8_t(1));
  arm_jet(rig, pattern.total());
  begin_pass(rig, pattern, 0);
  REQUIRE(rig.run([&] { return !rig.stage.busy(); }, 60.0));
  CHECK(rig.results("stage").back().counted == 51);
  check_shots(rig, firing_order(pattern, 0), 0, 51, grid);
  CHECK(rig.record.history.shots.size() == 51);
}

TEST_CASE("a scan gives one profile per row, at the row", "[world]") {
  WorldRig rig(WorldRig::small_world(10, 9));
  rig.start();
  const GridSpec grid = rig.world.config().grid;
  for (int repeat = 0; repeat < 2; ++repeat) {
    rig.events["laser_profiler"].clear();
    rig.act("laser_profiler", [&](std::int64_t t, Effects& fx) { rig.profiler.arm(grid.ny, t, fx); });
    REQUIRE(rig.run([&] { return rig.profiler.state() == DeviceState::kArmed; }, 5.0));
    rig.act("stage", [&](std::int64_t t, Effects& fx) {
      rig.stage.scan(1.0, grid.y_mm(0), 1.0, grid.pitch_y_mm, grid.ny, 15.0, t, fx);
    });
    REQUIRE(rig.run([&] { return !rig.stage.busy(); }, 60.0));
    CHECK(rig.results("stage").back().outcome == Outcome::kDone);
    rig.act("laser_profiler", [&](std::int64_t t, Effects& fx) { rig.profiler.end(t, fx); });
    REQUIRE(rig.run([&] { return !rig.profiler.busy(); }, 5.0));
    int row = 0;
    for (const DriverEvent& e : rig.events["laser_profiler"])
      if (const ProfileRow* p = event_cast<ProfileRow>(e)) {
        CHECK(p->row == row);
        CHECK(std::abs(p->encoder_count / 10000.0 - grid.y_mm(row)) < 0.0006 + 0.00005 * row);
        CHECK(p->x0_mm < grid.x_mm(0));
        CHECK(p->x0_mm + p->dx_mm * double(p->z_mm.size()) > grid.x_mm(grid.nx - 1));
        ++row;
      }
    CHECK(row == grid.ny);
  }
  CHECK(rig.record.history.shots.empty());
}

namespace {

/// The rows of one scan over a surface with droplets in one corner.
std::vector<ProfileRow> scanned(const plant::WorldConfig& config, const LaserProfilerOptions& options) {
  WorldRig rig(config, WorldRig::fast_stage(), {}, options);
  rig.start();
  const GridSpec grid = config.grid;
  DropletPattern corner(grid);
  for (int i = 0; i < 3; ++i) corner.at(i, 1) = 1;
  arm_jet(rig, 3);
  begin_pass(rig, corner, 0);
  REQUIRE(rig.run([&] { return !rig.stage.busy(); }, 60.0));
  rig.act("laser_profiler", [&](std::int64_t t, Effects& fx) { rig.profiler.arm(grid.ny, t, fx); });
  REQUIRE(rig.run([&] { return rig.profiler.state() == DeviceState::kArmed; }, 5.0));
  rig.act("stage", [&](std::int64_t t, Effects& fx) {
    rig.stage.scan(1.0, grid.y_mm(0), 1.0, grid.pitch_y_mm, grid.ny, 15.0, t, fx);
  });
  REQUIRE(rig.run([&] { return !rig.stage.busy(); }, 60.0));
  rig.run_for(0.1);
  return rig.all<ProfileRow>("laser_profiler");
}

}  // namespace

TEST_CASE("however the profiler's head is mounted, its rows are the part's", "[world][corrected:ljv-frame]") {
  plant::WorldConfig config = WorldRig::small_world(10, 4);
  config.sensor.noise_mm = 0.0;
  config.sensor.dropout_floor = 0.0;
  const std::vector<ProfileRow> wanted = scanned(config, {});
  REQUIRE(wanted.size() == 4);
  CHECK(*std::ranges::max_element(wanted[1].z_mm) > 0.002f);
  std::uint64_t seed = 17;
  for (int n = 0; n < 8; ++n) {
    LaserProfilerOptions options;
    options.offset_x_mm = config.profiler.head_x_mm = double(next(seed) % 200'000) * 1e-3 - 100.0;
    options.z_zero_mm = config.profiler.zero_mm = double(next(seed) % 20'000) * 1e-4 - 1.0;
    config.profiler.mirrored = n & 1;
    config.profiler.upside_down = n & 2;
    options.mirror_x = n & 1 ? OnOff::kOn : OnOff::kOff;
    options.z_sign = n & 2 ? ZSign::kDown : ZSign::kUp;
    const std::vector<ProfileRow> rows = scanned(config, options);
    REQUIRE(rows.size() == wanted.size());
    for (std::size_t r = 0; r < rows.size(); ++r) {
      INFO("mount " << n << ", row " << r);
      CHECK(rows[r].x0_mm == Approx(wanted[r].x0_mm).margin(2e-5));
      CHECK(rows[r].dx_mm == wanted[r].dx_mm);
      REQUIRE(rows[r].z_mm.size() == wanted[r].z_mm.size());
      for (std::size_t k = 0; k < rows[r].z_mm.size(); ++k)
        if (!std::isnan(wanted[r].z_mm[k]) && !std::isnan(rows[r].z_mm[k]))
          CHECK(std::abs(rows[r].z_mm[k] - wanted[r].z_mm[k]) < 3e-4f);
    }
  }
}

TEST_CASE("taken for part coordinates, as before, a head's rows lie beside their place and upside down",
          "[world][corrected:ljv-frame]") {
  plant::WorldConfig config = WorldRig::small_world(10, 4);
  config.sensor.noise_mm = config.sensor.dropout_floor = 0.0;
  const ProfileRow wanted = scanned(config, {}).at(1);
  config.profiler.head_x_mm = 40.0;
  config.profiler.upside_down = true;
  const ProfileRow read = scanned(config, {}).at(1);
  CHECK(read.x0_mm == Approx(wanted.x0_mm - 40.0).margin(1e-4));
  CHECK(*std::ranges::min_element(read.z_mm) == Approx(-*std::ranges::max_element(wanted.z_mm)).margin(3e-4));
}

TEST_CASE("an exposure opens the shutter once and for its time", "[world]") {
  for (const bool instrument_timer : {true, false}) {
    WorldRig rig(WorldRig::small_world(4, 4));
    rig.start();
    const double seconds = instrument_timer ? 0.5 : 0.55;  // 0.55 s is no whole tenth: the driver's timer
    rig.act("lamp", [&](std::int64_t t, Effects& fx) { rig.lamp.expose(seconds, 80, t, fx); });
    REQUIRE(rig.run([&] { return !rig.lamp.busy(); }, 10.0));
    CHECK(rig.results("lamp").back().outcome == Outcome::kDone);
    std::int64_t opened = 0, open_us = 0;
    for (const auto& e : rig.record.history.lamp) {
      if (e.event == plant::LampEvent::kOpened) {
        open_us -= e.t_us;
        ++opened;
      } else {
        open_us += e.t_us;
      }
    }
    CHECK(opened == 1);
    CHECK(std::abs(double(open_us) * 1e-6 - seconds) < 0.05);
    CHECK(rig.world.exposures() == 1);
  }
}

TEST_CASE("a safe stop during a pass ends all firing at once and the answer is the true prefix", "[world]") {
  int interrupted = 0;
  std::uint64_t seed = 7;
  for (int round = 0; round < 12; ++round) {
    WorldRig rig(WorldRig::small_world(12, 6));
    rig.start();
    const DropletPattern pattern = random_pattern(rig.world.config().grid, seed + std::uint64_t(round));
    arm_jet(rig, 1);
    begin_pass(rig, pattern, 0);
    rig.run_for(double(next(seed) % 700) * 1e-3);
    if (!rig.stage.busy()) continue;
    ++interrupted;
    rig.act("stage", [&](std::int64_t t, Effects& fx) { rig.stage.safe_stop(t, fx); });
    const std::int64_t asked_us = rig.now_us;
    REQUIRE(rig.run([&] { return !rig.stage.busy() && rig.stage.safe(); }, 10.0));
    const Result r = rig.results("stage").back();
    CHECK(r.counted == std::int64_t(rig.record.history.shots.size()));
    CHECK(r.unknown_from == r.unknown_to);
    CHECK((r.outcome == Outcome::kNone) == (r.counted == 0));
    for (const auto& shot : rig.record.history.shots) CHECK(shot.t_us <= asked_us + 1000);
    const std::size_t shots = rig.record.history.shots.size();
    rig.run_for(5.0);
    CHECK(rig.record.history.shots.size() == shots);
    // and it can go on: the rest as the scheduler sends it
    DropletPattern rest = pattern;
    const auto order = firing_order(pattern, 0);
    for (std::size_t n = 0; n < std::size_t(r.counted); ++n) rest.cells[order[n]] = 0;
    begin_pass(rig, rest, 0);
    REQUIRE(rig.run([&] { return !rig.stage.busy(); }, 60.0));
    CHECK(rig.results("stage").back().outcome == Outcome::kDone);
    CHECK(rig.record.history.shots.size() == order.size());
  }
  CHECK(interrupted >= 8);
}

TEST_CASE("a killed driver that comes back answers what the interrupted pass has truly fired", "[world]") {
  int interrupted = 0;
  std::uint64_t seed = 11;
  for (int round = 0; round < 20; ++round) {
    WorldRig rig(WorldRig::small_world(12, 6));
    rig.start();
    const DropletPattern pattern = random_pattern(rig.world.config().grid, seed + std::uint64_t(round));
    arm_jet(rig, 1);
    begin_pass(rig, pattern, 0);
    rig.run_for(double(next(seed) % 700) * 1e-3);
    if (!rig.stage.busy()) continue;
    ++interrupted;
    rig.kill("stage");
    rig.run_for(double(next(seed) % 3000) * 1e-3);
    rig.resume("stage");
    REQUIRE(rig.run([&] { return !rig.stage.busy() && rig.stage.safe(); }, 60.0));
    REQUIRE(rig.results("stage").size() == 1);
    const Result r = rig.results("stage").back();
    CHECK(r.counted == std::int64_t(rig.record.history.shots.size()));
    CHECK(r.unknown_from == r.unknown_to);
  }
  CHECK(interrupted >= 8);
}

TEST_CASE("a controller that rebooted leaves the pulses of its run in doubt, and no others", "[world]") {
  int interrupted = 0;
  std::uint64_t seed = 13;
  for (int round = 0; round < 12; ++round) {
    WorldRig rig(WorldRig::small_world(12, 6));
    rig.start();
    const DropletPattern pattern = random_pattern(rig.world.config().grid, seed + std::uint64_t(round));
    arm_jet(rig, 1);
    begin_pass(rig, pattern, 0);
    rig.run_for(double(next(seed) % 700) * 1e-3);
    if (!rig.stage.busy()) continue;
    ++interrupted;
    plant::SimFault reboot;
    reboot.port = "stage";
    reboot.kind = plant::FaultKind::kReboot;
    rig.world.inject(reboot, rig.now_us);
    REQUIRE(rig.run([&] { return !rig.stage.busy() && rig.stage.safe(); }, 120.0));
    const Result r = rig.results("stage").back();
    const auto fired = std::int64_t(rig.record.history.shots.size());
    CHECK(r.counted <= fired);
    CHECK((r.unknown_from == r.unknown_to ? r.counted == fired
                                          : r.unknown_from <= fired && fired <= r.unknown_to));
    CHECK(r.unknown_to - r.unknown_from <= 12);
  }
  CHECK(interrupted >= 8);
}

TEST_CASE("under lost, late and split replies and closed ports nothing fires twice and no answer is wrong",
          "[world]") {
  std::uint64_t seed = 17;
  int finished = 0, failed = 0;
  for (int round = 0; round < 30; ++round) {
    WorldRig rig(WorldRig::small_world(8, 5));
    rig.start();
    const DropletPattern pattern = random_pattern(rig.world.config().grid, seed + std::uint64_t(round));
    const auto order = firing_order(pattern, 0);
    arm_jet(rig, 1);
    begin_pass(rig, pattern, 0);
    for (int n = 0; n < 3 && rig.stage.busy(); ++n) {
      rig.run_for(double(next(seed) % 800) * 1e-3);
      plant::SimFault f;
      f.port = "stage";
      const plant::FaultKind kinds[] = {plant::FaultKind::kDropReply, plant::FaultKind::kDelayReply,
                                        plant::FaultKind::kSplitReply, plant::FaultKind::kClose};
      f.kind = kinds[next(seed) % 4];
      f.count = 1 + std::int64_t(next(seed) % 2);
      f.delay_us =
          f.kind == plant::FaultKind::kSplitReply ? 2000 : 2'000'000 + std::int64_t(next(seed) % 200'000);
      rig.world.inject(f, rig.now_us);
    }
    REQUIRE(rig.run([&] { return !rig.stage.busy() && rig.stage.safe(); }, 200.0));
    REQUIRE(rig.results("stage").size() == 1);
    const Result r = rig.results("stage").back();
    const auto fired = std::int64_t(rig.record.history.shots.size());
    INFO("round " << round << " " << drivers::test::describe(r));
    CHECK(r.counted <= fired);
    CHECK(fired <= std::max(r.counted, r.unknown_to));
    if (r.unknown_from == r.unknown_to) CHECK(r.counted == fired);
    check_shots(rig, order, 0, std::size_t(fired), rig.world.config().grid);
    (r.outcome == Outcome::kDone ? finished : failed)++;
  }
  CHECK(finished > 0);
  CHECK(failed > 0);
}

TEST_CASE("a stage takes commands again within 5 s after two answers in a row were lost", "[world]") {
  WorldRig rig(WorldRig::small_world(4, 4));
  rig.start();
  const auto move = [&](double x_mm) {
    rig.act("stage", [&](std::int64_t t, Effects& fx) { rig.stage.move_to(x_mm, 1.0, 1.0, 0.0, t, fx); });
  };
  rig.world.inject({"stage", plant::FaultKind::kDropReply, 2, 0}, rig.now_us);
  const std::int64_t before_us = rig.now_us;
  move(3.0);
  REQUIRE(rig.run([&] { return !rig.stage.busy() && rig.stage.safe(); }, 30.0));
  CHECK(double(rig.now_us - before_us) * 1e-6 < 5.0);
  move(2.0);
  REQUIRE(rig.run([&] { return !rig.stage.busy(); }, 30.0));
  CHECK(rig.results("stage").back().outcome == Outcome::kDone);
  CHECK(rig.sent("stage", "LINEAR @0 3") <= 1);
}

TEST_CASE("an emergency stop during a pass latches", "[world][I1]") {
  WorldRig rig(WorldRig::small_world(12, 6));
  rig.start();
  DropletPattern pattern(rig.world.config().grid);
  std::fill(pattern.cells.begin(), pattern.cells.end(), std::uint8_t(1));
  arm_jet(rig, 72);
  begin_pass(rig, pattern, 0);
  rig.run_for(0.4);
  REQUIRE(rig.stage.busy());
  plant::SimFault trip;
  trip.port = "stage";
  trip.kind = plant::FaultKind::kTrip;
  rig.world.inject(trip, rig.now_us);
  REQUIRE(rig.run([&] { return rig.stage.state() == DeviceState::kEstop; }, 10.0));
  REQUIRE(rig.results("stage").size() == 1);
  CHECK(rig.results("stage")[0].counted == std::int64_t(rig.record.history.shots.size()));
  begin_pass(rig, pattern, 0);
  CHECK(rig.results("stage").back().outcome == Outcome::kRefused);
  rig.run_for(3.0);
  CHECK(rig.stage.state() == DeviceState::kEstop);
}
