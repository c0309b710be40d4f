#include "core/grid/shapes.h"

#include <catch2/catch.hpp>
#include <cmath>

using namespace firn;

namespace {

const GridSpec kFine{201, 181, 0.1, 0.1, 5.0, -3.0};

ShapeSpec shape(const std::string& kind) {
  ShapeSpec s;
  s.kind = kind;
  s.height_mm = 0.5;
  s.diameter_mm = 12.0;
  s.inner_diameter_mm = 6.0;
  s.width_mm = 8.0;
  s.depth_mm = 6.0;
  return s;
}

double volume_mm3(const Target& t) {
  double sum = 0.0;
  for (double h : t.height.cells) sum += h;
  return sum * t.height.spec.pitch_x_mm * t.height.spec.pitch_y_mm;
}

}  // namespace

TEST_CASE("Volumes on a fine grid are those of the solids") {
  const double pi = std::acos(-1.0);
  const std::pair<const char*, double> volumes[] = {
      {"cylinder", pi * 36 * 0.5},     {"pipe", pi * (36 - 9) * 0.5}, {"cone", pi * 36 * 0.5 / 3},
      {"dome", 2 * pi * 36 * 0.5 / 3}, {"cuboid", 8 * 6 * 0.5},       {"wedge", 8 * 6 * 0.25}};
  REQUIRE(shape_kinds().size() == 6);
  for (const auto& [kind, volume] : volumes) {
    INFO(kind);
    CHECK(volume_mm3(make_shape(shape(kind), kFine)) == Approx(volume).epsilon(0.035));
  }
}

TEST_CASE("Every shape: zero outside its mask, heights within bounds and symmetric about the grid's middle") {
  for (const std::string& kind : shape_kinds()) {
    const Target t = make_shape(shape(kind), kFine);
    CHECK(t.mask.count() > 0);
    for (int j = 0; j < kFine.ny; ++j)
      for (int i = 0; i < kFine.nx; ++i) {
        const double h = t.height.at(i, j);
        if (!t.mask.at(i, j)) REQUIRE(h == 0.0);
        REQUIRE(h >= 0.0);
        REQUIRE(h <= 0.5);
        REQUIRE(t.mask.at(i, j) == t.mask.at(kFine.nx - 1 - i, j));
        REQUIRE(t.height.at(i, j) == Approx(t.height.at(i, kFine.ny - 1 - j)).margin(1e-12));
      }
  }
}

TEST_CASE(
    "A centre on the outline belongs to the part: 8 x 8 cells of a 7-pitch cuboid, a disc of 36 pitches") {
  const double pitch = 0.263256;
  const GridSpec g{40, 40, pitch, pitch};
  ShapeSpec s = shape("cuboid");
  s.width_mm = s.depth_mm = 7 * pitch;
  CHECK(make_shape(s, g).mask.count() == 64);
  s = shape("cylinder");
  s.diameter_mm = 36 * pitch;
  const Target disc = make_shape(s, GridSpec{41, 41, pitch, pitch});
  CHECK(disc.mask.at(2, 20) == 1);
  CHECK(disc.mask.at(1, 20) == 0);
}

TEST_CASE("A wedge rises from its low end, and its low end is not below its low height") {
  ShapeSpec s = shape("wedge");
  s.low_height_mm = 0.1;
  const Target t = make_shape(s, kFine);
  double least = 1.0, most = 0.0;
  for (std::size_t c = 0; c < t.mask.size(); ++c)
    if (t.mask.cells[c]) {
      least = std::min(least, t.height.cells[c]);
      most = std::max(most, t.height.cells[c]);
    }
  CHECK(least >= 0.1);
  CHECK(least == Approx(0.1).margin(1e-6));
  CHECK(most == Approx(0.5).margin(1e-6));
}

TEST_CASE("Sizes that make no part are refused by name") {
  const auto refused = [](auto change, const char* kind, const char* why) {
    ShapeSpec s = shape(kind);
    change(s);
    CHECK_THROWS_WITH(make_shape(s, kFine), Catch::Contains(why));
  };
  refused([](ShapeSpec& s) { s.kind = "cilinder"; }, "cylinder", "is not one of cylinder, pipe");
  refused([](ShapeSpec& s) { s.height_mm = 0.0; }, "cone", "height_mm");
  refused([](ShapeSpec& s) { s.diameter_mm = -1.0; }, "dome", "diameter_mm");
  refused([](ShapeSpec& s) { s.inner_diameter_mm = 12.0; }, "pipe", "inner_diameter_mm");
  refused([](ShapeSpec& s) { s.width_mm = std::nan(""); }, "cuboid", "width_mm");
  refused([](ShapeSpec& s) { s.depth_mm = 0.0; }, "wedge", "depth_mm");
  refused([](ShapeSpec& s) { s.low_height_mm = 0.6; }, "wedge", "low_height_mm");
  CHECK_THROWS_WITH(make_shape(
                        [] {
                          ShapeSpec s = shape("cylinder");
                          s.diameter_mm = 0.01;
                          return s;
                        }(),
                        GridSpec{4, 4}),
                    Catch::Contains("no cell centre"));
}
