// Droplets out of focus, and nozzles that are written over.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "core/vision/droplets.h"
#include "core/vision/rim.h"

using namespace firn;
using namespace firn::vision;

namespace {

/// Levels from 0 to 1 that are painted, blurred and taken as 8 bits.
struct SoftPicture {
  int width = 260, height = 260;
  std::vector<double> level = std::vector<double>(std::size_t(width) * std::size_t(height), 0.75);

  double& at(int x, int y) { return level[std::size_t(y) * std::size_t(width) + std::size_t(x)]; }
  void disc(double cx, double cy, double radius, double to) {
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        const double share = std::clamp(0.5 + radius - std::hypot(x - cx, y - cy), 0.0, 1.0);
        at(x, y) += share * (to - at(x, y));
      }
  }
  void box(int x0, int y0, int x1, int y1, double to) {
    for (int y = std::max(0, y0); y <= std::min(height - 1, y1); ++y)
      for (int x = std::max(0, x0); x <= std::min(width - 1, x1); ++x) at(x, y) = to;
  }
  /// A Gauss curve's blur by repeated means of neighbours, whose variance is a half of a pixel each.
  void blur(double sigma_px) {
    for (int n = 0; n < int(2.0 * sigma_px * sigma_px + 0.5); ++n)
      for (const bool across : {true, false}) {
        const std::vector<double> old = level;
        const auto before = [&](int x, int y) {
          return old[std::size_t(std::clamp(y, 0, height - 1)) * std::size_t(width) +
                     std::size_t(std::clamp(x, 0, width - 1))];
        };
        for (int y = 0; y < height; ++y)
          for (int x = 0; x < width; ++x)
            at(x, y) = across ? 0.25 * before(x - 1, y) + 0.5 * before(x, y) + 0.25 * before(x + 1, y)
                              : 0.25 * before(x, y - 1) + 0.5 * before(x, y) + 0.25 * before(x, y + 1);
      }
  }
  Frame frame() const {
    Frame f{width, height, 255, {}};
    for (const double v : level) f.pixels.push_back(std::uint16_t(255.0 * v + 0.5));
    return f;
  }
};

constexpr double kLiquid = 0.1, kGround = 0.75;

}  // namespace

TEST_CASE("A droplet out of focus with a bright middle is measured within 3 %") {
  const double blur = GENERATE(2.0, 3.0, 4.0, 5.0), middle = GENERATE(0.0, 0.3, 0.5, 0.65);
  const double radius = 20.0;
  SoftPicture p;
  p.box(95, 0, 165, 30, kLiquid);
  p.disc(130.3, 140.2, radius, kLiquid);
  if (middle > 0.0) p.disc(130.3, 140.2, middle * radius, kGround);
  p.blur(blur);
  const DropletPicture found = find_droplets(p.frame(), nullptr);
  CAPTURE(blur, middle);
  REQUIRE(found.state == PictureState::kDrop);
  CHECK(found.main.x == Approx(130.3).margin(0.3));
  CHECK(found.main.y == Approx(140.2).margin(0.3));
  CHECK(found.main.diameter_px == Approx(2.0 * radius).epsilon(0.03));
}

TEST_CASE("A fibre is no droplet, upright or aslant") {
  const double across = GENERATE(0.0, 40.0, 90.0), half_width = GENERATE(1.5, 3.0);
  SoftPicture p;
  for (double way = -1.0; way <= 1.0; way += 0.005)
    p.disc(130.0 + across * way, 130.0 + 90.0 * way, half_width, kLiquid);
  p.blur(1.0);
  const DropletPicture found = find_droplets(p.frame(), nullptr);
  CAPTURE(across, half_width, found.main.diameter_px);
  CHECK(found.state == PictureState::kNoDrop);
}

TEST_CASE("However far out of focus a droplet is, its diameter lies within three stated deviations") {
  const double blur = GENERATE(1.0, 3.0, 4.0, 6.0), radius = GENERATE(8.0, 15.0, 30.0);
  SoftPicture p;
  p.disc(130.3, 130.4, radius, kLiquid);
  p.blur(blur);
  const DropletPicture found = find_droplets(p.frame(), nullptr);
  CAPTURE(blur, radius, found.blur_px, found.main.diameter_px, found.main.diameter_std_px);
  REQUIRE(found.state == PictureState::kDrop);
  CHECK(std::abs(found.main.diameter_px - 2.0 * radius) < 3.0 * found.main.diameter_std_px);
  if (blur < 2.0) CHECK(found.main.diameter_std_px < 0.1);
}

TEST_CASE("The fitted rim of a profile made by the model is the model's own") {
  const double sigma = 3.0, width = GENERATE(4.0, 7.0, 9.5), edge = -1.3;
  std::vector<double> profile;
  for (double d = -16.0; d <= 9.0; d += 0.5)
    profile.push_back(0.5 * std::erfc((d - edge) / sigma / std::sqrt(2.0)) -
                      0.9 * 0.5 * std::erfc((d - edge + width) / sigma / std::sqrt(2.0)));
  const RimFit fit = fit_rim(profile, -16.0, 0.5, 2.0);
  REQUIRE(fit.found);
  CHECK(fit.edge_px == Approx(edge).margin(0.05));
  CHECK(fit.width_px == Approx(width).margin(0.1));
  CHECK(fit.blur_px == Approx(sigma).margin(0.05));
}

TEST_CASE("A rim that reaches its plateau, a filled disc and a flat profile are no thin rim") {
  const auto profile_of = [](double sigma, double width, double share) {
    std::vector<double> p;
    for (double d = -12.0; d <= 8.0; d += 0.5)
      p.push_back(0.5 * std::erfc(d / sigma / std::sqrt(2.0)) -
                  share * 0.5 * std::erfc((d + width) / sigma / std::sqrt(2.0)));
    return p;
  };
  CHECK_FALSE(fit_rim(profile_of(1.0, 8.0, 0.9), -12.0, 0.5, 1.0).found);
  CHECK_FALSE(fit_rim(profile_of(2.0, 5.0, 0.0), -12.0, 0.5, 2.0).found);
  CHECK_FALSE(fit_rim(std::vector<double>(40, 0.0), -12.0, 0.5, 2.0).found);
  CHECK_FALSE(fit_rim(std::vector<double>(3, 1.0), -12.0, 0.5, 2.0).found);
}

TEST_CASE("Writing over a nozzle's flank, beside it or across it leaves its width as it is") {
  const double ink = GENERATE(0.0, 1.0);
  const int first = GENERATE(60, 85, 110, 150);
  SoftPicture p;
  p.box(100, 0, 160, 50, kLiquid);
  p.disc(130.0, 150.0, 16.0, kLiquid);
  // Letters of strokes 3 px wide and 22 px high, each with a bar at its foot and one in the middle.
  for (int n = 0; n < 4; ++n) {
    const int x = first + 16 * n;
    p.box(x, 22, x + 2, 44, ink);
    p.box(x, 42, x + 10, 44, ink);
    p.box(x, 32, x + 8, 34, ink);
  }
  p.blur(0.8);
  CAPTURE(ink, first);
  const DropletPicture found = find_droplets(p.frame(), nullptr);
  REQUIRE(found.nozzle.found);
  CHECK(found.nozzle.width_px == Approx(61.0).margin(1.0));
  CHECK(found.nozzle.edge.x == Approx(130.0).margin(1.0));
  CHECK(found.state == PictureState::kDrop);
  CHECK(found.main.diameter_px == Approx(32.0).epsilon(0.03));
}

TEST_CASE("A tapered nozzle has the width of its end") {
  SoftPicture p;
  for (int y = 0; y <= 60; ++y) {
    const int half = 60 - y / 2;  // 30 at the end
    p.box(130 - half, y, 130 + half, y, kLiquid);
  }
  p.disc(130.0, 170.0, 16.0, kLiquid);
  p.blur(0.8);
  const DropletPicture found = find_droplets(p.frame(), nullptr);
  REQUIRE(found.nozzle.found);
  CHECK(found.nozzle.width_px == Approx(72.0).margin(9.0));  // near its edge
  CHECK(found.nozzle.edge.y == Approx(60.5).margin(1.0));
}
