#include <catch2/catch.hpp>

#include <cmath>
#include <vector>

#include "plant/inkjet/sensor.h"

using namespace firn;
using namespace firn::plant;

namespace {
const GridSpec kGrid{20, 20, 0.263256, 0.263256, 0.0, 0.0};
}

TEST_CASE("Sensor noise on flat ground is white, unbiased and 1 um") {
  const Field field(kGrid, 3, 3);
  SensorParams p;
  p.dropout_floor = 0.0;
  double sum = 0, square = 0, lagged = 0, fourth = 0;
  const int rows = 200, points = 800;
  std::vector<double> z(points);
  for (int row = 0; row < rows; ++row) {
    measure_profile(field, p, {5, 1, std::uint32_t(row)}, 1.0, -1.0, 0.01, z);
    for (int n = 0; n < points; ++n) {
      sum += z[n];
      square += z[n] * z[n];
      fourth += z[n] * z[n] * z[n] * z[n];
      if (n > 0) lagged += z[n] * z[n - 1];
    }
  }
  const double count = double(rows) * points, variance = square / count;
  CHECK(std::abs(sum / count) < 4e-3 / std::sqrt(count));
  CHECK(std::sqrt(variance) * 1e3 == Approx(1.0).epsilon(0.01));
  CHECK(std::abs(lagged / square) < 4.0 / std::sqrt(count));
  CHECK(fourth / count / (variance * variance) == Approx(3.0).epsilon(0.05));
}

TEST_CASE("A profile depends on its key alone") {
  const Field field(kGrid, 3, 3);
  std::vector<double> a(800), b(800), c(800);
  const SensorParams p;
  measure_profile(field, p, {5, 1, 9}, 1.0, -1.0, 0.01, a);
  measure_profile(field, p, {5, 1, 9}, 2.0, -1.0, 0.01, b);
  measure_profile(field, p, {5, 1, 10}, 1.0, -1.0, 0.01, c);
  for (int n = 0; n < 800; ++n) {
    if (!std::isnan(a[n])) CHECK(a[n] == b[n]);
    CHECK(std::isnan(a[n]) == std::isnan(b[n]));
  }
  CHECK(a != c);
}

TEST_CASE("Drop-outs grow with the slope and stay rare on level ground") {
  Field field(kGrid, 3, 3);
  for (int b = 0; b < field.height(); ++b)
    for (int a = field.width() / 2; a < field.width(); ++a)
      field.set_solid_mm(a, b, (a - field.width() / 2) * field.dx_mm() * 2.0);  // level, then slope 2
  SensorParams p;
  p.dropout_floor = 1e-4;
  std::vector<double> z(400);
  int level = 0, steep = 0;
  const double middle = field.left_mm() + 0.5 * field.width() * field.dx_mm();
  for (int row = 0; row < 50; ++row) {
    measure_profile(field, p, {5, 1, std::uint32_t(row)}, 1.0, middle - 2.2, 0.005, z);
    for (const double v : z) level += std::isnan(v);
    measure_profile(field, p, {5, 1, std::uint32_t(100 + row)}, 1.0, middle + 0.2, 0.005, z);
    for (const double v : z) steep += std::isnan(v);
  }
  CHECK(level < 15);
  CHECK(steep / 20000.0 == Approx(p.dropout_floor + p.dropout_per_slope * 1.5).epsilon(0.05));
}

TEST_CASE(
    "Without noise the sensor follows a ramp across x exactly and sees the substrate beside the field") {
  Field field(kGrid, 4, 3);
  for (int b = 0; b < field.height(); ++b)
    for (int a = 0; a < field.width(); ++a) field.set_solid_mm(a, b, 0.1 * (a + 0.5) * field.dx_mm());
  SensorParams p;
  p.noise_mm = p.dropout_floor = 0.0;
  std::vector<double> z(100);
  measure_profile(field, p, {1, 0, 0}, 2.0, 0.5, 0.02, z);
  for (int n = 0; n < 100; ++n) CHECK(z[n] == Approx(0.1 * (0.5 + 0.02 * n - field.left_mm())).margin(1e-12));
  measure_profile(field, p, {1, 0, 0}, 2.0, -50.0, 0.02, z);
  for (const double v : z) CHECK(v == 0.0);
}

TEST_CASE("A tilted sensor adds its tilt along the profile about the middle of the field") {
  const Field field(kGrid, 3, 3);
  SensorParams p;
  p.noise_mm = p.dropout_floor = 0.0;
  p.tilt = 0.01;
  std::vector<double> z(100);
  const double middle = field.left_mm() + 0.5 * field.width() * field.dx_mm();
  measure_profile(field, p, {5, 1, 0}, 1.0, middle - 0.5, 0.01, z);
  for (int n = 0; n < 100; ++n) CHECK(z[std::size_t(n)] == Approx(0.01 * (0.01 * n - 0.5)).margin(1e-12));
}
