#include <catch2/catch.hpp>

#include <cmath>
#include <numbers>

#include "core/grid/random.h"
#include "plant/ice/bed.h"
#include "plant/ice/point_laser.h"

using namespace firn;
using namespace firn::plant;

namespace {

IceWorldConfig still() {
  IceWorldConfig c;
  c.disturbance.roughness = c.disturbance.pattern = 0.0;
  c.table.roughness_mm = 0.0;
  c.field = {0.25, -20.0, -20.0, 40.0, 40.0};
  return c;
}

double balance(const Bed& bed) {
  const IceLedger& l = bed.ledger();
  const double landed = l.landed[0] + l.landed[1];
  return (landed + l.grown + l.debris - l.lost - bed.volume_mm3()) / landed;
}

// Drops of 0.25 mm^3 along y = at with `area_mm2` per length.
void bead(Bed& bed, double at_mm, double area_mm2, int material = 0) {
  const double spacing = 0.25 / area_mm2;
  for (double x = -12.0; x < 12.0; x += spacing) bed.land({x, at_mm, 0.25, area_mm2, material});
}

}  // namespace

TEST_CASE("What leaves the nozzle is on the field, beside it or grown by freezing, on any ground") {
  IceWorldConfig c = still();
  c.disturbance.roughness = 0.2;
  c.disturbance.pattern = 0.05;
  c.table.roughness_mm = 0.1;
  Bed bed(c, 9);
  RandomStream random(9, Purpose::kTest);
  for (int k = 0; k < 20000; ++k) {
    if (k % 500 == 0) bed.set_nozzle_height(0.1 * k / 500);
    if (k % 3000 == 7) bed.add_debris(random.uniform(-15, 15), random.uniform(-15, 15), 0.5, 1.5);
    bed.land({random.uniform(-21.0, 21.0), random.uniform(-21.0, 21.0), random.uniform(0.01, 0.6),
              random.uniform(0.0, 1.2), int(random.below(2))});
  }
  CHECK(bed.ledger().lost > 0.0);
  CHECK(std::abs(balance(bed)) < 1e-10);
}

TEST_CASE("A bead has the cross-section Q / c, and layers of it add up") {
  for (const double area : {0.2, 0.36, 0.72}) {
    Bed bed(still(), 1);
    for (int layer = 1; layer <= 3; ++layer) {
      bead(bed, 0.0, area);
      double section = 0.0;
      int columns = 0;
      for (int i = 0; i < bed.width(); ++i) {
        if (std::abs(bed.centre_x_mm(i)) > 6.0) continue;
        ++columns;
        for (int j = 0; j < bed.height(); ++j) section += bed.z_mm(i, j) * bed.cell_mm();
      }
      CHECK(section / columns == Approx(area * layer).epsilon(0.03));
    }
  }
}

TEST_CASE("Neighbouring beads of the thesis's widths make a nearly level layer 0.24 mm high") {
  for (const double width : {1.5, 3.0}) {
    Bed bed(still(), 1);
    for (int layer = 1; layer <= 4; ++layer) {
      for (double y = -15.0; y <= 15.01; y += width) bead(bed, y, width * 0.24);
      double sum = 0.0, square = 0.0;
      int n = 0;
      for (int j = 0; j < bed.height(); ++j)
        for (int i = 0; i < bed.width(); ++i)
          if (std::abs(bed.centre_x_mm(i)) < 3.0 && std::abs(bed.centre_y_mm(j)) < 3.0) {
            sum += bed.z_mm(i, j);
            square += bed.z_mm(i, j) * bed.z_mm(i, j);
            ++n;
          }
      const double mean = sum / n, ripple = std::sqrt(std::max(0.0, square / n - mean * mean));
      INFO(width << " mm, layer " << layer);
      CHECK(mean == Approx(0.24 * layer).epsilon(0.02));
      CHECK(ripple < 0.02);
    }
  }
}

TEST_CASE("A pool fills a hollow before it raises the level beside it") {
  Bed bed(still(), 1);
  for (double y = -6.0; y <= 6.01; y += 1.5)
    if (std::abs(y) > 0.1) bead(bed, y, 0.36);
  const double before = bed.height_mm(0.0, 1.0) - bed.height_mm(0.0, 0.0);
  bead(bed, 0.0, 0.36);
  const double after = bed.height_mm(0.0, 1.0) - bed.height_mm(0.0, 0.0);
  CHECK(before > 0.1);
  CHECK(std::abs(after) < 0.6 * before);
}

TEST_CASE("Edges fall off without scaffold, and water contained by scaffold does not") {
  const auto edge_height = [](bool contained) {
    Bed bed(still(), 1);
    for (int layer = 0; layer < 20; ++layer) {
      if (contained) {
        for (const double y : {-8.25, -6.75, 6.75, 8.25}) bead(bed, y, 0.36, 1);
      }
      for (double y = -5.25; y <= 5.26; y += 1.5) bead(bed, y, 0.36);
    }
    double sum = 0.0;
    int n = 0;
    for (double x = -6.0; x <= 6.0; x += 0.25)
      for (double y = 5.0; y <= 5.9; y += 0.1) {
        sum += bed.height_mm(x, y);
        ++n;
      }
    return sum / n - bed.height_mm(0.0, 0.0);
  };
  const double open = edge_height(false), held = edge_height(true);
  CHECK(open < -0.05);
  CHECK(held > 0.5 * open);
}

TEST_CASE("Roughness is new in every layer, the same for every run of a seed, and of the stated size") {
  IceWorldConfig c = still();
  c.disturbance.roughness = 0.2;
  const auto increments = [&](std::uint64_t seed, double z_mm) {
    Bed bed(c, seed);
    bed.set_nozzle_height(z_mm);
    for (double y = -9.0; y <= 9.01; y += 1.5) bead(bed, y, 0.36);
    std::vector<double> z;
    for (double y = -6.0; y <= 6.0; y += 0.5)
      for (double x = -6.0; x <= 6.0; x += 0.5) z.push_back(bed.height_mm(x, y));
    return z;
  };
  CHECK(increments(1, 3.24) == increments(1, 3.24));
  CHECK(increments(1, 3.24) != increments(1, 3.48));
  CHECK(increments(1, 3.24) != increments(2, 3.24));
}

TEST_CASE("The mean over a coarse grid is the mean of the fine cells, and says where it knows nothing") {
  Bed bed(still(), 1);
  bead(bed, 0.3, 0.5);
  const HeightMap coarse = bed.mean_over({20, 20, 1.9, 1.9, -0.95 * 19, -0.95 * 19});
  double volume = 0.0;
  for (const double z : coarse.cells) volume += z * 1.9 * 1.9;
  CHECK(volume == Approx(bed.volume_mm3()).epsilon(1e-9));
  const HeightMap beyond = bed.mean_over({2, 1, 30.0, 30.0, 0.0, 0.0});
  CHECK(std::isfinite(beyond.cells[0]));
  CHECK(std::isnan(beyond.cells[1]));
  const HeightMap ice = bed.thickness_over(coarse.spec, 0), sme = bed.thickness_over(coarse.spec, 1);
  for (std::size_t n = 0; n < coarse.cells.size(); ++n) {
    CHECK(ice.cells[n] == Approx(coarse.cells[n]).margin(1e-12));
    CHECK(sme.cells[n] == Approx(0.0).margin(1e-12));
  }
}

TEST_CASE("The laser reads well with the right settings at the thesis's speeds and badly otherwise") {
  const IceWorldConfig c = still();
  Bed bed(c, 1);
  for (int layer = 0; layer < 4; ++layer)
    for (double y = -9.0; y <= 9.01; y += 1.5) bead(bed, y, 0.36, y < 0.0 ? 0 : 1);
  const auto look = [&](double y_mm, double speed, LaserSettings settings) {
    ArmPose pose;
    pose.z_mm = 1.0;
    pose.vx_mm_s = speed;
    double square = 0.0, missing = 0.0;
    int n = 0;
    for (int k = 0; k < 4000; ++k) {
      pose.x_mm = -6.0 + 12.0 * k / 4000.0;
      pose.y_mm = y_mm;
      const double z = laser_reading_mm(c.laser, bed, {}, pose, settings, {1, 1, std::uint32_t(k)});
      if (std::isnan(z)) {
        missing += 1.0;
        continue;
      }
      const double error = z - (bed.height_mm(pose.x_mm, y_mm) - 1.0);
      square += error * error;
      ++n;
    }
    return std::pair{std::sqrt(square / n), missing / 4000.0};
  };
  const auto [slow, slow_missing] = look(-5.0, 50.0, LaserSettings::kIce);
  const auto [fast, fast_missing] = look(-5.0, 125.0, LaserSettings::kIce);
  const auto [wrong, wrong_missing] = look(-5.0, 50.0, LaserSettings::kScaffold);
  const auto [sme, sme_missing] = look(5.0, 125.0, LaserSettings::kScaffold);
  CHECK(slow < 0.05);
  CHECK(slow_missing < 0.03);
  CHECK(fast > 1.5 * slow);
  CHECK(fast_missing > slow_missing);
  CHECK(wrong > 0.15);
  CHECK(wrong_missing > 0.2);
  CHECK(sme < 0.02);
  CHECK(sme_missing < 0.02);
}

TEST_CASE(
    "The laser is straight to 0.05 % of its range, repeats to 0.05 um and says when it is out of range") {
  const IceWorldConfig c = still();
  const Bed bed(c, 1);
  ArmPose pose;
  for (double z = -4.9; z <= 4.9; z += 0.1) {
    pose.z_mm = z;
    const double read =
        laser_reading_mm(c.laser, bed, {}, pose, LaserSettings::kIce, {1, 1, std::uint32_t((z + 5.0) * 10)});
    CHECK(std::abs(read + z) < 0.0005 * 10.0 + 5 * 0.00005);
  }
  pose.z_mm = 5.5;
  CHECK(laser_reading_mm(c.laser, bed, {}, pose, LaserSettings::kIce, {}) ==
        -std::numeric_limits<double>::infinity());
  pose.z_mm = -5.5;
  CHECK(laser_reading_mm(c.laser, bed, {}, pose, LaserSettings::kIce, {}) ==
        std::numeric_limits<double>::infinity());
}
