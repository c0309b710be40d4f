// Scaffold below overhangs only, on shapes whose overhang is known in closed form.
#include <catch2/catch.hpp>

#include <cmath>
#include <functional>

#include "core/geometry/planar.h"
#include "core/slice/support/scaffold.h"
#include "tests/core/slice/offset_oracle.h"
#include "tests/core/slice/outlines.h"

namespace firn::slice {
namespace {

constexpr double kHeightMm = 0.25, kTolerance = 0.01;
constexpr std::int32_t kHeight = 2500;

std::vector<geometry::Region> stack(int layers,
                                    const std::function<void(geometry::Region&, double z_mm)>& draw) {
  std::vector<geometry::Region> part(std::size_t(layers), geometry::Region{});
  for (int k = 0; k < layers; ++k) draw(part[std::size_t(k)], (k + 0.5) * kHeightMm);
  return part;
}

// A cone that stands on its tip, walls leaning out by `lean_deg` from the vertical.
std::vector<geometry::Region> cone(double lean_deg) {
  return stack(40, [&](geometry::Region& r, double z) {
    outlines::add_circle(r, 0, 0, 3 + z * std::tan(lean_deg * outlines::kPi / 180), 240);
  });
}

std::vector<geometry::Region> ball(double radius) {
  return stack(int(2 * radius / kHeightMm), [&](geometry::Region& r, double z) {
    outlines::add_circle(r, 0, 0, std::sqrt(std::max(0.01, radius * radius - (z - radius) * (z - radius))),
                         240);
  });
}

std::vector<geometry::Region> t_beam() {
  return stack(24, [](geometry::Region& r, double z) {
    z < 4 ? outlines::add_box(r, -3, 0, 3, 30) : outlines::add_box(r, -12, 0, 12, 30);
  });
}

// A star that grows upward by `rate` per mm.
std::vector<geometry::Region> leaning_star(std::uint64_t seed, double rate) {
  return stack(24, [&](geometry::Region& r, double z) {
    r = outlines::random_star(seed, 11, 3, 9);
    for (geometry::Point& p : r.points) p = geometry::to_point((1 + rate * z) * to_vec(p));
  });
}

std::vector<geometry::Region> overhang(const std::vector<geometry::Region>& part, double deg,
                                       double buffer_mm = 3.3) {
  return scaffold_regions(
      part, kHeight,
      {.kind = Support::kOverhang, .buffer_mm = buffer_mm, .overhang_rad = deg * outlines::kPi / 180},
      kTolerance);
}

double volume_mm3(const std::vector<geometry::Region>& layers) {
  double sum = 0;
  for (const geometry::Region& r : layers) sum += area_mm2(r) * kHeightMm;
  return sum;
}

bool stands(const geometry::Region& r, geometry::Vec p) { return winding(r, geometry::to_point(p)) > 0; }

TEST_CASE("A cone is supported below its own angle and not above it") {
  for (const double lean : {20.0, 35.0, 50.0, 65.0}) {
    INFO("lean " << lean);
    CHECK(volume_mm3(overhang(cone(lean), lean + 1.5)) == 0.0);
    CHECK(volume_mm3(overhang(cone(lean), lean - 1.5)) > 0.0);
  }
}

TEST_CASE("A ball is supported where its wall leans out more than the angle: below latitude -angle") {
  const double radius = 10;
  const std::vector<geometry::Region> part = ball(radius);
  for (const double deg : {30.0, 45.0, 60.0}) {
    INFO("angle " << deg);
    const std::vector<geometry::Region> scaffold = overhang(part, deg, 0.6);
    // The wall at height z (from the middle) leans out by asin(-z / r) from the vertical.
    const double z_mm = radius - radius * std::sin(deg * outlines::kPi / 180);
    int highest = 0;
    for (int k = 0; k < int(scaffold.size()); ++k)
      if (!scaffold[std::size_t(k)].empty()) highest = k + 1;
    CHECK(highest * kHeightMm == Approx(z_mm).margin(2 * kHeightMm + 0.1));
  }
}

TEST_CASE("What overhangs has scaffold or part below it, all the way down to part or ground") {
  for (const auto& part : {cone(60), ball(8), t_beam()}) {
    for (const double deg : {20.0, 45.0}) {
      const std::vector<geometry::Region> scaffold = overhang(part, deg);
      const double lean = kHeightMm * std::tan(deg * outlines::kPi / 180) * geometry::kUnitsPerMm;
      for (std::size_t k = 1; k < part.size(); ++k) {
        const std::vector<oracle::Segment> below = oracle::segments_of(part[k - 1]);
        for (const geometry::Vec p : oracle::along(part[k], 9000)) {
          const geometry::Vec inside = 0.9995 * p;  // all of these are round the origin or the beam's middle
          if (stands(part[k - 1], inside) || oracle::distance_to_all(inside, below) <= 1.15 * lean + 60)
            continue;
          INFO("layer " << k + 1 << " at " << p.x * geometry::kMmPerUnit << ", " << p.y * geometry::kMmPerUnit
                        << ", angle " << deg);
          for (std::size_t j = k; j-- > 0;) {
            if (stands(part[j], inside)) break;
            CHECK(stands(scaffold[j], inside));
          }
        }
      }
    }
  }
}

TEST_CASE("Overhang scaffold stays within the buffer of what lies above it, and out of the part") {
  for (const auto& part : {cone(60), ball(8), t_beam()}) {
    const std::vector<geometry::Region> scaffold = overhang(part, 30);
    for (std::size_t k = 0; k < part.size(); k += 3) {
      for (const geometry::Vec p : oracle::along(scaffold[k], 7000)) {
        bool above = false;
        for (std::size_t j = k + 1; j < part.size() && !above; ++j)
          above = stands(part[j], p) || oracle::distance_to_all(p, oracle::segments_of(part[j])) <= 33000;
        CHECK(above);
      }
      CHECK(area_mm2(common(scaffold[k], part[k])) < 1e-6);
    }
  }
}

TEST_CASE(
    "The steeper the angle asked for, the less scaffold, and none at all is full support of whatever leans "
    "out") {
  for (const auto& part : {cone(50), ball(8), t_beam(), leaning_star(2, 0.3), leaning_star(4, 1.0)}) {
    double before = 1e300;
    for (const double deg : {0.0, 5.0, 20.0, 40.0, 60.0, 70.0, 80.0, 85.0, 87.0, 89.0}) {
      const double volume = volume_mm3(overhang(part, deg));
      CHECK(volume <= before * (1 + 2e-4) + 1e-6);
      before = volume;
    }
  }
  CHECK(volume_mm3(overhang(t_beam(), 89.0)) ==
        0.0);  // 9 mm to each side is less than a layer's 14.3 mm at 89 degrees
  CHECK(volume_mm3(overhang(t_beam(), 60.0)) > 4.0 * 2 * 9 * 30 * 0.9);
  CHECK(volume_mm3(overhang(ball(8), 0.0)) < volume_mm3(scaffold_regions(ball(8), kHeight, {}, kTolerance)));
}

}  // namespace
}  // namespace firn::slice
