// Faults of real instruments, which any nature of the ink-jet lab can meet.
#include <catch2/catch.hpp>

#include <cmath>
#include <numbers>
#include <vector>

#include "plant/inkjet/instrument_faults.h"
#include "plant/inkjet/sensor.h"

using namespace firn;
using namespace firn::plant;

namespace {

const GridSpec kPlate{20, 20, 0.25, 0.25, 0.0, 0.0};

SensorParams noiseless() {
  SensorParams p;
  p.noise_mm = p.dropout_floor = p.dropout_per_slope = 0.0;
  return p;
}

/// A step of 0.1 mm at x = 2.375 mm.
Field step_field() {
  Field field(kPlate, 1, 0);
  for (int b = 0; b < field.height(); ++b)
    for (int a = 10; a < field.width(); ++a) field.set_solid_mm(a, b, 0.1);
  return field;
}

std::vector<double> profile(const Field& field, const SensorParams& p, std::uint32_t trigger = 1) {
  std::vector<double> z(400);
  measure_profile(field, p, {7, 1, trigger}, 1.0, 0.0, 0.01, z);
  return z;
}

}  // namespace

TEST_CASE("A sensor's scale multiplies heights, and neither its noise nor its tilt") {
  SensorParams p = noiseless(), scaled = p;
  p.tilt = scaled.tilt = 1e-3;
  scaled.scale = 1.02;
  const Field field = step_field();
  const auto a = profile(field, p), b = profile(field, scaled);
  for (std::size_t n = 0; n < a.size(); ++n)
    CHECK(b[n] - a[n] == Approx(0.02 * (n < 238 ? 0.0 : 0.1)).margin(1e-15));
}

TEST_CASE("Correlated noise has its deviation and its correlation length") {
  SensorParams p = noiseless();
  p.wave_mm = 0.003;
  p.wave_length_mm = 0.5;
  const Field flat(kPlate, 1, 0);
  double square = 0.0, lagged = 0.0;
  const int profiles = 800, lag = 50;  // 0.5 mm
  std::int64_t count = 0;
  for (int t = 0; t < profiles; ++t) {
    const auto z = profile(flat, p, std::uint32_t(t));
    for (std::size_t n = lag; n < z.size(); ++n, ++count) {
      square += z[n] * z[n];
      lagged += z[n] * z[n - lag];
    }
  }
  CHECK(std::sqrt(square / double(count)) == Approx(0.003).epsilon(0.03));
  CHECK(lagged / square == Approx(std::exp(-1.0)).margin(0.04));
}

TEST_CASE("Ground beside an edge shows a ghost of it, within its reach and nowhere else") {
  SensorParams p = noiseless();
  p.ghost_share = 0.1;
  p.ghost_reach_mm = 0.3;
  const auto z = profile(step_field(), p);
  for (std::size_t n = 0; n < z.size(); ++n) {
    const double x_mm = 0.01 * double(n);
    if (x_mm < 2.06) CHECK(z[n] == 0.0);
    if (x_mm > 2.09 && x_mm < 2.37) CHECK(z[n] == Approx(0.01).margin(1e-15));
    if (x_mm > 2.38) CHECK(z[n] == Approx(0.1).margin(1e-15));
  }
}

TEST_CASE("A step below the least one shows no ghost") {
  SensorParams p = noiseless();
  p.ghost_share = 0.5;
  p.ghost_step_mm = 0.2;
  const auto z = profile(step_field(), p);
  CHECK(z[230] == 0.0);
}

TEST_CASE("Faults of a sensor that are off change no byte of its readings") {
  SensorParams p, other = p;
  other.ghost_reach_mm = 1.0;
  other.wave_length_mm = 9.0;
  const auto a = profile(step_field(), p), b = profile(step_field(), other);
  for (std::size_t n = 0; n < a.size(); ++n) CHECK((a[n] == b[n] || (std::isnan(a[n]) && std::isnan(b[n]))));
}

TEST_CASE("The stage's place is that of its encoder, its error map and its lost motion") {
  StageFaults f;
  CHECK(true_place(f, kPlate, {3.0, 4.0}, 10.0).x_mm == 3.0);
  f.backlash_mm = 0.04;
  CHECK(true_place(f, kPlate, {3.0, 4.0}, 10.0).x_mm == Approx(2.98));
  CHECK(true_place(f, kPlate, {3.0, 4.0}, -10.0).x_mm == Approx(3.02));
  CHECK(true_place(f, kPlate, {3.0, 4.0}, 0.0).x_mm == Approx(3.0));
  f = {};
  f.stretch_x = 1e-3;
  f.stretch_y = -2e-3;
  CHECK(true_place(f, kPlate, {3.0, 4.0}, 0.0).x_mm == Approx(3.003));
  CHECK(true_place(f, kPlate, {3.0, 4.0}, 0.0).y_mm == Approx(3.992));
  f = {};
  f.cyclic_mm = 0.02;
  f.cyclic_period_mm = 4.0;
  CHECK(true_place(f, kPlate, {3.0, 4.0}, 0.0).x_mm == Approx(3.0 - 0.02));
}

TEST_CASE("A wetted nozzle deflects droplets from its layer on") {
  NozzleFaults f;
  f.deflect_x_mm = 0.05;
  f.deflect_layer = 3;
  NozzleFault nozzle(f);
  CHECK(nozzle.fire(0, 2, 1).dx_mm == 0.0);
  CHECK(nozzle.fire(1, 3, 1).dx_mm == 0.05);
  CHECK(nozzle.fire(1, 3, 1).droplets == 1);
}

TEST_CASE("A nozzle that has died fires nothing from its layer on") {
  NozzleFaults f;
  f.dead_layer = 5;
  NozzleFault nozzle(f);
  CHECK(nozzle.fire(0, 4, 1).droplets == 1);
  CHECK(nozzle.fire(0, 5, 1).droplets == 0);
  CHECK(nozzle.fire(0, 6, 2).droplets == 0);
}

TEST_CASE("After a long rest the first droplets are missing, and the next ones come") {
  NozzleFaults f;
  f.weak_idle_s = 2.0;
  f.weak_droplets = 2;
  NozzleFault nozzle(f);
  std::vector<int> fired;
  for (const std::int64_t t_us : {0, 1000, 2000, 3000, 2'500'000, 2'501'000, 2'502'000, 4'000'000})
    fired.push_back(nozzle.fire(t_us, 1, 1).droplets);
  CHECK(fired == std::vector<int>{0, 0, 1, 1, 0, 0, 1, 1});
}

TEST_CASE("After a long rest ink drips with the first droplet") {
  NozzleFaults f;
  f.drip_idle_s = 1.0;
  NozzleFault nozzle(f);
  std::vector<int> fired;
  for (const std::int64_t t_us : {0, 1000, 2'000'000, 2'000'500})
    fired.push_back(nozzle.fire(t_us, 1, 1).droplets);
  CHECK(fired == std::vector<int>{2, 1, 2, 1});
}
