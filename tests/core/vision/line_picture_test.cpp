#include "core/vision/line_picture.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/grid/random.h"
#include "plant/aerosol/line_picture.h"

using namespace firn;
using namespace firn::vision;
using plant::LineCamera;

namespace {

constexpr double kInkSigma_mm = 0.03, kInkDepth_mm = 0.002, kInkPeak_mm = 0.004;

LineCamera camera_over_lines() {
  LineCamera c;
  c.um_per_px = 4.0;
  c.slope_x = 0.2;
  c.vignette = 0.2;
  c.flicker = 0.02;
  c.dirt = {{60, 80, 5, 0.5, 1.0}, {200, 150, 4, 0.4, 2.0}, {160, 161, 3, 0.5, 0.7}};
  return c;
}

// A line along x at y_mm, without material between two places.
Frame picture_of_line(const LineCamera& c, double y_mm, double gap_from_mm = 0.0, double gap_to_mm = 0.0,
                      std::uint32_t exposure = 0) {
  const auto thickness = [&](std::span<const double> xs_mm, std::span<const double> ys_mm,
                             std::span<double> ink_mm) {
    for (std::size_t n = 0; n < ink_mm.size(); ++n) {
      const double d = (ys_mm[n] - y_mm) / kInkSigma_mm;
      ink_mm[n] = xs_mm[n] > gap_from_mm && xs_mm[n] < gap_to_mm ? 0.0 : kInkPeak_mm * std::exp(-0.5 * d * d);
    }
  };
  const plant::TakenPicture p = plant::render_lines(c, thickness, 7, exposure);
  return {p.width, p.height, p.white, p.pixels};
}

Frame light_of(const LineCamera& c) {
  std::vector<Frame> bare;
  for (std::uint32_t n = 0; n < 5; ++n) {
    const plant::TakenPicture p = plant::render_lines(c, nullptr, 7, 100 + n);
    bare.push_back({p.width, p.height, p.white, p.pixels});
  }
  std::vector<const Frame*> pointers;
  for (const Frame& f : bare) pointers.push_back(&f);
  return flat_field(pointers);
}

LineView view_of_middle() { return {{159.5, 159.5}, {1, 0}, 240.0, 2.3548 * kInkSigma_mm / 0.004, 100.0}; }

// Full width at half contrast in closed form [Beer and Lambert].
double visible_px() {
  const double a = kInkPeak_mm / kInkDepth_mm, half = -std::log(0.5 * (1.0 + std::exp(-a)));
  return 2.0 * kInkSigma_mm * std::sqrt(2.0 * std::log(a / half)) / 0.004;
}

}  // namespace

TEST_CASE("A line in a picture has the width at half contrast that the law of Beer and Lambert gives") {
  const LineCamera c = camera_over_lines();
  const Frame light = light_of(c);
  const LinePictureReading r = measure_line_picture(picture_of_line(c, 0.02), &light, view_of_middle());
  REQUIRE(r.seen);
  CHECK(r.width_px == Approx(visible_px()).margin(0.25));
  CHECK(std::abs(r.width_px - visible_px()) < 4.0 * r.width_std_px);
  CHECK(0.5 * (r.left_px + r.right_px) == Approx(5.0).margin(0.15));
  CHECK(r.gaps.empty());
  CHECK(r.overspray == Approx(0.0).margin(0.01));
}

TEST_CASE("A gap in a line is found with both of its ends") {
  const LineCamera c = camera_over_lines();
  const Frame light = light_of(c);
  const LinePictureReading r =
      measure_line_picture(picture_of_line(c, 0.0, 0.1, 0.18), &light, view_of_middle());
  REQUIRE(r.seen);
  REQUIRE(r.gaps.size() == 1);
  CHECK(r.gaps[0].from_px == Approx(119.5 + 25.0).margin(1.0));
  CHECK(r.gaps[0].to_px == Approx(119.5 + 45.0).margin(1.0));
  CHECK(r.width_px == Approx(visible_px()).margin(0.3));
}

TEST_CASE("The edges of a line do not depend on the side from which it is travelled") {
  const LineCamera c = camera_over_lines();
  const Frame light = light_of(c), picture = picture_of_line(c, 0.02);
  LineView back = view_of_middle();
  back.direction = {-1, 0};
  const LinePictureReading there = measure_line_picture(picture, &light, view_of_middle()),
                           here = measure_line_picture(picture, &light, back);
  CHECK(there.left_px == Approx(-here.right_px).margin(1e-6));
  CHECK(there.width_px == Approx(here.width_px).margin(1e-6));
}

TEST_CASE("A bright line on a dark ground is read as a dark one on a bright ground is") {
  LineCamera c = camera_over_lines();
  c.bright = true;
  const Frame light = light_of(c);
  const LinePictureReading r = measure_line_picture(picture_of_line(c, 0.02), &light, view_of_middle());
  REQUIRE(r.seen);
  CHECK(r.contrast < 0.0);
  CHECK(r.width_px == Approx(visible_px()).margin(0.35));
}

TEST_CASE("Bare pictures, pictures of another size and windows beside the picture show no line") {
  const LineCamera c = camera_over_lines();
  const Frame light = light_of(c), picture = picture_of_line(c, 0.0);
  LineCamera small = c;
  small.width = 100;
  const plant::TakenPicture bare = plant::render_lines(c, nullptr, 7, 50);
  CHECK_FALSE(
      measure_line_picture({bare.width, bare.height, bare.white, bare.pixels}, &light, view_of_middle())
          .seen);
  CHECK_FALSE(measure_line_picture({}, nullptr, view_of_middle()).seen);
  LineView beside = view_of_middle();
  beside.middle = {5000, 5000};
  CHECK_FALSE(measure_line_picture(picture, &light, beside).seen);
  const Frame other = light_of(small);
  CHECK(measure_line_picture(picture, &other, view_of_middle()).seen);  // without the light of another size
}

TEST_CASE("The light is the median of the bare pictures at equal brightness") {
  std::vector<Frame> bare(3, Frame{16, 16, 255, std::vector<std::uint16_t>(256, 100)});
  for (std::uint16_t& p : bare[1].pixels) p = 50;
  bare[2].pixels[40] = 10;  // a speck that moved
  std::vector<const Frame*> pointers;
  for (const Frame& f : bare) pointers.push_back(&f);
  const Frame light = flat_field(pointers);
  REQUIRE(light.pixels.size() == 256);
  CHECK(double(light.pixels[40]) == Approx(double(light.pixels[41])).epsilon(0.01));
  CHECK(flat_field({}).pixels.empty());
}
