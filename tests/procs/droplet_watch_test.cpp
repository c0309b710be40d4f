// The droplet watch: rendered strobe sweeps in, one DROPLET_SWEEP out.
#include <catch2/catch.hpp>
#include <cmath>

#include "core/grid/png.h"
#include "firn/droplet_sweep_t.hpp"
#include "firn/enums.h"
#include "firn/fault_t.hpp"
#include "plant/inkjet/strobe_picture.h"
#include "procs/droplet_watch/node.h"
#include "tests/support/node_bench.h"

namespace firn::test {
namespace {

plant::StrobeCamera strobe_camera() {
  plant::StrobeCamera c;
  c.width = 320;
  c.height = 300;
  c.um_per_px = 2.0;
  c.nozzle_x_px = 160;
  c.nozzle_y_px = 40;
  return c;
}

struct Watch : NodeBench {
  explicit Watch(const Experiment& e)
      : NodeBench(NodeId::kDropletWatch, std::make_unique<DropletWatchNode>(e)) {
    start();
  }
  // Pictures [0, count) of the sweep's 12.
  void show(std::int64_t sweep, const plant::StrobeJet* jet, int count = 12, int white = 255) {
    plant::StrobeCamera c = strobe_camera();
    c.white = white;
    for (int k = 0; k < count; ++k) {
      const plant::StrobePicture p =
          plant::render_strobe(c, jet, 70.0 + 12.0 * k, std::uint64_t(sweep), std::uint32_t(k));
      camera_frame_t m{};
      const auto png = write_grey_png(p.width, p.height, p.white, p.pixels);
      m.png.assign(reinterpret_cast<const std::uint8_t*>(png.data()),
                   reinterpret_cast<const std::uint8_t*>(png.data()) + png.size());
      if (damage && k == 3) m.png[m.png.size() / 2] ^= 0x40;
      m.n = std::int32_t(m.png.size());
      m.sweep_id = sweep;
      m.layer = 3;
      m.index = k;
      m.frames = 12;
      m.width = p.width;
      m.height = p.height;
      m.white = p.white;
      m.delay_us = 70.0 + 12.0 * k;
      give(channels::kCameraFrame, m);
    }
  }
  bool damage = false;
};

Experiment scaled() {
  Experiment e;
  e.watch.um_per_px = 2.0;
  return e;
}

bool known(const droplet_sweep_t& m, SweepValue v) { return m.known & std::int32_t(v); }

}  // namespace

TEST_CASE("A sweep of 12 pictures gives velocity, angle, size and satellites of its jet, with deviations") {
  const int white = GENERATE(255, 4095);
  Watch watch(scaled());
  plant::StrobeJet jet;
  jet.angle_deg = 2.0;
  watch.show(1, &jet, 12, white);
  REQUIRE(watch.all(channels::kDropletSweep).size() == 1);
  const droplet_sweep_t m = watch.last(channels::kDropletSweep);
  CHECK(m.sweep_id == 1);
  CHECK(m.layer == 3);
  CHECK(m.frames == 12);
  for (const SweepValue v : {SweepValue::kVelocity, SweepValue::kAngle, SweepValue::kDiameter,
                             SweepValue::kVolume, SweepValue::kSatellites, SweepValue::kJitter})
    CHECK(known(m, v));
  const double speed = plant::fly(jet.speed_m_s, jet.diameter_um, m.middle_us).speed_m_s;
  CHECK(m.velocity_mm_s == Approx(1e3 * speed).epsilon(0.005));
  CHECK(m.velocity_std_mm_s > 0.0);
  CHECK(m.velocity_std_mm_s < 0.01 * m.velocity_mm_s);
  CHECK(m.angle_rad * 57.29577951 == Approx(2.0).margin(0.1));
  CHECK(m.diameter_mm == Approx(1e-3 * jet.diameter_um).epsilon(0.01));
  CHECK(m.volume_mm3 == Approx(3.14159265 / 6 * std::pow(1e-3 * jet.diameter_um, 3)).epsilon(0.03));
  CHECK(m.satellites == 0.0);
}

TEST_CASE("The nozzle's width gives the scale where the lab file does") {
  Experiment e;
  e.watch.nozzle_um = strobe_camera().nozzle_um;
  Watch watch(e);
  const plant::StrobeJet jet;
  watch.show(1, &jet);
  const droplet_sweep_t m = watch.last(channels::kDropletSweep);
  CHECK(m.um_per_px == Approx(2.0).epsilon(0.01));
  CHECK(m.um_per_px_std > 0.0);
}

TEST_CASE("Without a scale a sweep counts its droplets and knows no velocity") {
  Watch watch(Experiment{});
  const plant::StrobeJet jet;
  watch.show(1, &jet);
  const droplet_sweep_t m = watch.last(channels::kDropletSweep);
  CHECK(m.um_per_px == 0.0);
  CHECK(m.with_droplet > 6);
  CHECK_FALSE(known(m, SweepValue::kVelocity));
}

TEST_CASE("An empty scene has no droplet, and no value is known") {
  Watch watch(scaled());
  watch.show(1, nullptr);
  const droplet_sweep_t m = watch.last(channels::kDropletSweep);
  CHECK(m.with_droplet == 0);
  CHECK(m.known == 0);
}

TEST_CASE("The first picture of another sweep ends one that was cut off") {
  Watch watch(scaled());
  const plant::StrobeJet jet;
  watch.show(1, &jet, 8);
  CHECK(watch.all(channels::kDropletSweep).empty());
  watch.show(2, &jet);
  const auto sweeps = watch.all(channels::kDropletSweep);
  REQUIRE(sweeps.size() == 2);
  CHECK(sweeps[0].sweep_id == 1);
  CHECK(sweeps[0].frames == 8);
  CHECK(sweeps[1].frames == 12);
}

TEST_CASE("A picture that cannot be decoded is left out and named") {
  Watch watch(scaled());
  const plant::StrobeJet jet;
  watch.damage = true;
  watch.show(7, &jet);
  CHECK(watch.last(channels::kDropletSweep).frames == 11);
  const auto warnings = watch.all(channels::fault(NodeId::kDropletWatch));
  REQUIRE(warnings.size() == 1);
  CHECK_THAT(warnings[0].text, Catch::Contains("CAMERA_FRAME 3 of sweep 7 is damaged"));
}

}  // namespace firn::test
