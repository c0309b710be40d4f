// Stage, jet and camera in the simulated world: what the camera sees of the jet, and where droplets land.
#include <catch2/catch.hpp>
#include <cmath>

#include "core/vision/flight.h"
#include "core/vision/sweep.h"
#include "drivers/camera/camera.h"
#include "drivers/jet/jet.h"
#include "plant/inkjet/strobe_scene.h"
#include "tests/drivers/port_rig.h"
#include "tests/drivers/world_rig.h"

namespace firn::drivers::test {
namespace {

plant::WorldConfig world_of(double speed_m_s) {
  plant::WorldConfig c = WorldRig::small_world(10, 6);
  c.droplet.placement_scatter_mm = 0.0;
  c.droplet.missed_probability = 0.0;
  c.strobe.speed_m_s = speed_m_s;
  c.strobe.nozzle_gap_mm = 1.0;
  c.droplet.flight_time_s = plant::fall_s(c, c.strobe.speed_m_s);
  return c;
}

struct WatchRig : PortRig {
  explicit WatchRig(const plant::WorldConfig& config)
      : PortRig(config), stage(WorldRig::fast_stage()), jet(JetOptions{}), camera(CameraOptions{}) {
    add("stage", stage);
    add("jet", jet);
    add("camera", camera);
    connect_all();
  }
  void to_camera() {
    act("stage", [&](std::int64_t t, Effects& fx) { stage.move_to(-5, -5, 1, 50, t, fx); });
    REQUIRE(run([&] { return !stage.busy(); }, 20.0));
  }
  void begin_jet() {
    act("jet", [&](std::int64_t t, Effects& fx) { jet.jet(t, fx); });
    REQUIRE(run([&] { return !jet.busy(); }, 10.0));
    REQUIRE(all<Result>("jet").back().outcome == Outcome::kReady);
  }
  void end_jet() {
    act("jet", [&](std::int64_t t, Effects& fx) { jet.disarm(t, fx); });
    REQUIRE(run([&] { return !jet.busy(); }, 10.0));
  }
  vision::SweepResult look(double first_us, double step_us, int frames) {
    events["camera"].clear();
    act("camera", [&](std::int64_t t, Effects& fx) { camera.sweep({frames, first_us, step_us}, t, fx); });
    REQUIRE(run([&] { return !camera.busy(); }, 60.0));
    std::vector<vision::Frame> pictures;
    std::vector<const vision::Frame*> all_of_them;
    for (const CameraShot& s : all<CameraShot>("camera"))
      pictures.push_back({s.picture.width, s.picture.height, s.picture.white, s.picture.pixels});
    for (const vision::Frame& f : pictures) all_of_them.push_back(&f);
    const auto background = vision::find_background(all_of_them, true);
    std::vector<vision::TimedPicture> timed;
    for (std::size_t k = 0; k < pictures.size(); ++k)
      timed.push_back({first_us + step_us * double(k),
                       vision::find_droplets(pictures[k], background ? &*background : nullptr)});
    return vision::measure_sweep(timed, {world.config().strobe.um_per_px, 0.0});
  }

  Stage stage;
  Jet jet;
  Camera camera;
};

}  // namespace

TEST_CASE("The camera sees droplets while the jet jets, and none before and after", "[world]") {
  WatchRig rig(world_of(2.0));
  rig.to_camera();
  CHECK(rig.look(60, 15, 8).with_droplet == 0);
  rig.begin_jet();
  CHECK(rig.jet.state() == DeviceState::kActive);
  const vision::SweepResult r = rig.look(60, 15, 10);
  CHECK(r.with_droplet == 10);
  REQUIRE(r.velocity_m_s.known);
  const double diameter_um =
      plant::strobe_jet(rig.world.config(), rig.world.config().strobe.speed_m_s).diameter_um;
  CHECK(r.velocity_m_s.value == Approx(plant::fly(2.0, diameter_um, r.middle_us).speed_m_s).epsilon(0.005));
  CHECK(r.diameter_um.value == Approx(diameter_um).epsilon(0.01));
  rig.end_jet();
  CHECK(rig.look(60, 15, 8).with_droplet == 0);
  CHECK(rig.record.history.shots.empty());  // they fell into the tray
}

TEST_CASE("A stop ends the jetting, and a jet that jets takes no waveform", "[world]") {
  WatchRig rig(world_of(2.0));
  rig.begin_jet();
  rig.act("jet", [&](std::int64_t t, Effects& fx) { rig.jet.set_waveform({}, t, fx); });
  CHECK(rig.all<Result>("jet").back().outcome == Outcome::kRefused);
  rig.act("jet", [&](std::int64_t t, Effects& fx) { rig.jet.arm(5, t, fx); });
  CHECK(rig.all<Result>("jet").back().outcome == Outcome::kRefused);
  rig.act("jet", [&](std::int64_t t, Effects& fx) { rig.jet.safe_stop(t, fx); });
  REQUIRE(rig.run([&] { return rig.jet.safe(); }, 5.0));
  CHECK(rig.look(60, 15, 8).with_droplet == 0);
}

TEST_CASE("Jetting ends of itself after the longest time that the lab file gives", "[world]") {
  WatchRig rig(world_of(2.0));
  rig.begin_jet();
  REQUIRE(rig.run([&] { return rig.jet.safe(); }, JetDialect{}.most_continuous_s + 5.0));
  CHECK(rig.all<Fault>("jet").back().code == kJetLimit);
}

// The sweep's velocity gives the lead; rows of either direction fire earlier by it.
TEST_CASE("With the camera's lead droplets land within 3 um of their cells at 1 to 4 m/s", "[world]") {
  const double speed_m_s = GENERATE(1.0, 1.7, 2.5, 4.0), stage_mm_s = 150.0;
  WatchRig rig(world_of(speed_m_s));
  rig.to_camera();
  rig.begin_jet();
  const double first_us = 60.0, step_us = 2.0 * 200.0 / speed_m_s / 12.0;
  const vision::SweepResult r = rig.look(first_us, step_us, 12);
  rig.end_jet();
  REQUIRE(r.velocity_m_s.known);
  const double fall_s = vision::flight_time_s(
      {1e3 * r.velocity_m_s.value, 1e-6 * r.middle_us, 1e-3 * r.diameter_um.value}, 1.0);
  const GridSpec grid = rig.world.config().grid;
  DropletPattern pattern(grid);
  for (auto& c : pattern.cells) c = 1;
  rig.act("jet", [&](std::int64_t t, Effects& fx) { rig.jet.arm(pattern.total(), t, fx); });
  REQUIRE(rig.run([&] { return !rig.jet.busy(); }, 10.0));
  rig.act("stage", [&](std::int64_t t, Effects& fx) {
    rig.stage.run_pass(pattern, 0, 1.0, stage_mm_s, t, fx, stage_mm_s * fall_s);
  });
  REQUIRE(rig.run([&] { return !rig.stage.busy(); }, 120.0));
  CHECK(rig.all<Result>("stage").back().outcome == Outcome::kDone);
  REQUIRE(rig.record.history.shots.size() == std::size_t(pattern.total()));
  double worst_um = 0.0;
  for (const plant::ShotRecord& s : rig.record.history.shots) {
    REQUIRE(grid.contains(s.i, s.j));
    worst_um = std::max(worst_um, 1e3 * std::abs(s.landed_x_mm - grid.x_mm(s.i)));
  }
  INFO("worst " << worst_um << " um, lead " << 1e3 * stage_mm_s * fall_s << " um");
  CHECK(worst_um <= 3.0);
}

}  // namespace firn::drivers::test
