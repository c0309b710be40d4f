// Velocity, angle, size, break-off and jitter of pictures at several delays.
#include <catch2/catch.hpp>
#include <cmath>

#include "core/grid/random.h"
#include "core/vision/sweep.h"

using namespace firn;
using namespace firn::vision;

namespace {

TimedPicture seen(double delay, double x, double y, double d = 30) {
  TimedPicture t{delay, {}};
  t.picture.state = PictureState::kDrop;
  t.picture.main = {x, y, 0.02, 0.02, d, 0.1, 1.0, 0.0, 1.0, false};
  t.picture.blur_px = 1.0;
  return t;
}

}  // namespace

TEST_CASE("A droplet on a line has the line's velocity and angle, whatever the pictures' order") {
  std::vector<TimedPicture> p;
  for (const double t : {80.0, 20.0, 60.0, 40.0, 100.0}) p.push_back(seen(t, 100 + 0.02 * t, 50 + 1.5 * t));
  const SweepResult r = measure_sweep(p, {2.0, 0.0});
  REQUIRE(r.velocity_m_s.known);
  CHECK(r.used == 5);
  CHECK(r.velocity_m_s.value == Approx(2 * std::hypot(0.02, 1.5)));
  CHECK(r.angle_deg.value == Approx(std::atan(0.02 / 1.5) * 57.29577951308232));
  CHECK(r.diameter_um.value == Approx(60));
  CHECK(r.volume_pl.value == Approx(3.14159265 / 6 * 216));
  CHECK(r.middle_us == Approx(60));
}

TEST_CASE("The stated deviations of velocity, angle and jitter are those of many sweeps") {
  int velocity = 0, angle = 0;
  double jitter = 0.0;
  constexpr int kSweeps = 400;
  for (std::uint64_t seed = 0; seed < kSweeps; ++seed) {
    RandomStream random(seed, Purpose::kTest);
    std::vector<TimedPicture> p;
    for (int k = 0; k < 12; ++k) {
      const double t = 20.0 + 8 * k, late = t + 0.4 * random.normal();
      p.push_back(
          seen(t, 100 + 0.05 * late + 0.02 * random.normal(), 50 + 1.2 * late + 0.02 * random.normal()));
    }
    const SweepResult r = measure_sweep(p, {2.0, 0.0});
    velocity += std::abs(r.velocity_m_s.value - 2 * std::hypot(0.05, 1.2)) < 1.96 * r.velocity_m_s.std;
    angle += std::abs(r.angle_deg.value - std::atan(0.05 / 1.2) * 57.29577951308232) < 1.96 * r.angle_deg.std;
    jitter += r.jitter_us.value / kSweeps;
  }
  CHECK(velocity >= 0.90 * kSweeps);
  CHECK(velocity <= 0.985 * kSweeps);
  CHECK(angle >= 0.90 * kSweeps);
  CHECK(angle <= 0.99 * kSweeps);
  CHECK(jitter == Approx(0.4).epsilon(0.08));
}

TEST_CASE("The stated deviation of the velocity covers a jet that jitters, from three pictures on") {
  const int pictures = GENERATE(3, 4, 5, 6, 8);
  const double jitter_us = GENERATE(0.4, 4.0);
  int covered = 0;
  constexpr int kSweeps = 400;
  for (std::uint64_t seed = 0; seed < kSweeps; ++seed) {
    RandomStream random(seed, Purpose::kTest);
    std::vector<TimedPicture> p;
    for (int k = 0; k < pictures; ++k) {
      const double t = 20.0 + 96.0 * k / (pictures - 1), late = t + jitter_us * random.normal();
      p.push_back(seen(t, 100, 50 + 1.2 * late + 0.02 * random.normal()));
    }
    const SweepResult r = measure_sweep(p, {2.0, 0.0});
    covered += std::abs(r.velocity_m_s.value - 2.4) < 1.96 * r.velocity_m_s.std;
  }
  CAPTURE(pictures, jitter_us);
  CHECK(covered >= 0.84 * kSweeps);
  CHECK(covered <= 0.985 * kSweeps);
}

TEST_CASE("Two of three pictures do not outvote the third, three of four do") {
  std::vector<TimedPicture> p{seen(0, 100, 250), seen(60, 100, 160), seen(120, 100, 340)};
  const SweepResult three = measure_sweep(p, {1.0, 0.0});
  CHECK(three.used == 3);
  CHECK(three.velocity_m_s.std > 0.5);
  p[1].picture.main.y = 295;
  p.push_back(seen(90, 100, 20));
  const SweepResult four = measure_sweep(p, {1.0, 0.0});
  CHECK(four.used == 3);
  CHECK(four.velocity_m_s.value == Approx(0.75));
}

TEST_CASE("A picture whose largest droplet is another one is followed to the right one, or left out") {
  std::vector<TimedPicture> p;
  for (int k = 0; k < 8; ++k) p.push_back(seen(10.0 * k, 100, 50 + 15.0 * k));
  p[3].picture.drops.push_back(p[3].picture.main);
  p[3].picture.main.y = 300;
  p[6].picture.main.x = 20;
  const SweepResult r = measure_sweep(p, {1.0, 0.0});
  CHECK(r.used == 7);
  CHECK(r.velocity_m_s.value == Approx(1.5));
}

TEST_CASE("Break-off lies between the last ligament and the first free droplet, one wrong picture or not") {
  std::vector<TimedPicture> p;
  for (int k = 0; k < 12; ++k) {
    p.push_back(seen(10.0 * k, 100, 50 + 15.0 * k));
    if (k < 5) p.back().picture.state = PictureState::kNotBrokenOff;
  }
  p[8].picture.state = PictureState::kNotBrokenOff;
  const SweepResult r = measure_sweep(p, {1.0, 0.0});
  REQUIRE(r.break_off_us.known);
  CHECK(r.break_off_us.value == Approx(45));
  CHECK(r.break_off_us.std == Approx(10 / std::sqrt(12.0)));
  for (TimedPicture& t : p) t.picture.state = PictureState::kDrop;
  CHECK_FALSE(measure_sweep(p, {1.0, 0.0}).break_off_us.known);
}

TEST_CASE("No droplet, one delay and an unknown scale leave unknown what they do not determine") {
  const TimedPicture none{5.0, {}};
  CHECK_FALSE(measure_sweep(std::vector{none, none}, {1.0, 0.0}).velocity_m_s.known);
  const SweepResult still = measure_sweep(std::vector{seen(5, 10, 10), seen(5, 10, 10.2)}, {1.0, 0.0});
  CHECK_FALSE(still.velocity_m_s.known);
  CHECK(still.diameter_um.known);
  CHECK_FALSE(measure_sweep(std::vector{seen(5, 10, 10), seen(9, 10, 20)}, {}).diameter_um.known);
}

TEST_CASE("The scale comes from the nozzle's width or from a lattice of dots") {
  std::vector<DropletPicture> p(3);
  for (int k = 0; k < 2; ++k) {
    p[std::size_t(k)].nozzle.found = true;
    p[std::size_t(k)].nozzle.width_px = 100 + 0.2 * k;
    p[std::size_t(k)].nozzle.width_std_px = 0.1;
  }
  const Scale scale = scale_from_nozzle(p, 200);
  CHECK(scale.um_per_px == Approx(200 / 100.1));
  CHECK(scale.std > 0.001);
  DropletPicture dots;
  dots.state = PictureState::kDrop;
  for (int k = 0; k < 16; ++k) {
    const Droplet d{20.0 + 25 * (k % 4), 30.0 + 25 * (k / 4), 0.01, 0.01, 10, 0.1};
    if (k == 0)
      dots.main = d;
    else
      dots.drops.push_back(d);
  }
  CHECK(scale_from_target(dots, 50).um_per_px == Approx(2));
  dots.drops.resize(7);
  CHECK(scale_from_target(dots, 50).um_per_px == 0);
}

TEST_CASE("The arc tangent without transcendental functions is the arc tangent") {
  for (double x = -300; x < 300; x += 0.37)
    CHECK(arc_tangent(x) == Approx(std::atan(x)).epsilon(1e-12).margin(1e-15));
}

TEST_CASE("Drag bends the path and neither the velocity nor the jitter") {
  // x(t) of a droplet slowed by dv/dt = -c v^m, integrated in small steps.
  const double power = GENERATE(1.0, 1.35, 1.69), loss = GENERATE(0.02, 0.1, 0.2);
  std::vector<TimedPicture> pictures;
  double x = 50.0, v = 2.0;  // px, px/us
  const double c = loss * std::pow(v, 1.0 - power) / 120.0;
  double middle_v = 0.0;
  for (int us = 0; us <= 120; ++us) {
    if (us == 60) middle_v = v;
    if (us % 10 == 0) {
      DropletPicture p;
      p.state = PictureState::kDrop;
      p.main = {100.0, x, 0.01, 0.01, 20.0, 0.1};
      pictures.push_back({double(us), p});
    }
    for (int n = 0; n < 100; ++n) {
      x += 0.01 * v;
      v -= 0.01 * c * std::pow(v, power);
    }
  }
  const SweepResult r = measure_sweep(pictures, {1.0, 0.0});
  REQUIRE(r.velocity_m_s.known);
  CHECK(r.middle_us == Approx(60.0));
  CHECK(std::abs(r.velocity_m_s.value - middle_v) < 2.0 * r.velocity_m_s.std);
  CHECK(r.velocity_m_s.std < 1e-3 * middle_v);
  CHECK(r.jitter_us.value * middle_v < 0.02);  // px
}
