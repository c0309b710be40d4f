#include "core/grid/geometry.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>

#include "core/grid/material_columns.h"
#include "core/grid/random.h"
#include "core/grid/solids.h"

using namespace firn;

namespace {

const GridSpec kGrid{60, 40, 0.25, 0.3, 1.0, -2.0};

SolidSpec junction() {
  SolidSpec s;
  s.kind = "pipe_junction";
  s.outer_diameter_mm = 7.0;
  s.inner_diameter_mm = 4.0;
  s.branch_width_mm = 5.0;
  s.branch_height_mm = 0.3;
  s.branch_bore_width_mm = 3.0;
  s.branch_bore_height_mm = 0.16;
  s.centre_z_mm = 0.2;
  return s;
}

SolidSpec ellipsoid() {
  SolidSpec s;
  s.kind = "ellipsoid";
  s.outer_diameter_mm = 8.0;
  s.height_mm = 0.3;
  s.centre_z_mm = 0.2;
  return s;
}

}  // namespace

TEST_CASE("A sampled geometry answers as its solid does, away from the spans' ends") {
  RandomStream random(7, Purpose::kTest);
  for (const SolidSpec& spec : {junction(), ellipsoid()}) {
    const auto solid = make_solid(spec, kGrid);
    const Geometry g = Geometry::sampled(*solid, kGrid, 0.4, 0.002);
    for (int n = 0; n < 20000; ++n) {
      const std::size_t c = random.below(std::uint32_t(kGrid.size()));
      const double z = random.uniform(0.0, 0.4);
      const double x = kGrid.x_mm(int(c) % kGrid.nx), y = kGrid.y_mm(int(c) / kGrid.nx);
      bool near_end = false;
      for (const Span& s : g.spans(c))
        near_end = near_end || std::abs(z - s.from_mm) < 0.002 || std::abs(z - s.to_mm) < 0.002;
      if (near_end || !g.spans(c).size()) continue;
      CHECK((g.at(c, z) == Material::kA) == solid->contains(x, y, z));
    }
  }
}

TEST_CASE("Span ends of an ellipsoid are those of its equation") {
  const SolidSpec s = ellipsoid();
  const Geometry g = Geometry::sampled(*make_solid(s, kGrid), kGrid, 0.4, 0.004);
  const double cx = 0.5 * (kGrid.x_mm(0) + kGrid.x_mm(59)), cy = 0.5 * (kGrid.y_mm(0) + kGrid.y_mm(39));
  int columns = 0;
  for (int j = 0; j < kGrid.ny; ++j)
    for (int i = 0; i < kGrid.nx; ++i) {
      const double x = (kGrid.x_mm(i) - cx) / 4.0, y = (kGrid.y_mm(j) - cy) / 4.0, left = 1.0 - x * x - y * y;
      const auto spans = g.spans(kGrid.index(i, j));
      if (left < 0.01) continue;
      REQUIRE(spans.size() == 1);
      CHECK(spans[0].from_mm == Approx(0.2 - 0.15 * std::sqrt(left)).margin(1e-6));
      CHECK(spans[0].to_mm == Approx(0.2 + 0.15 * std::sqrt(left)).margin(1e-6));
      ++columns;
    }
  CHECK(columns > 500);
}

TEST_CASE("The pipe junction is two pipes whose bores join, and stands on support where it overhangs") {
  const Geometry g = Geometry::sampled(*make_solid(junction(), kGrid), kGrid, 0.4, 0.002);
  const auto cell = [](double x, double y) {  // relative to the middle
    return kGrid.index(int(std::lround((x + 0.5 * 59 * 0.25) / 0.25)),
                       int(std::lround((y + 0.5 * 39 * 0.3) / 0.3)));
  };
  CHECK(g.spans(cell(0.1, 0.1)).empty());         // the bore of the standing pipe
  REQUIRE(g.spans(cell(-2.6, 0.1)).size() == 1);  // its wall, all the way up
  CHECK(g.spans(cell(-2.6, 0.1))[0] == Span{0.0, 0.4});
  CHECK(g.spans(cell(2.6, 0.1)).size() == 2);  // its wall, pierced by the lying pipe's bore
  const auto out = g.spans(cell(5.6, 0.1));    // the lying pipe: wall, bore, wall
  REQUIRE(out.size() == 2);
  CHECK(out[0].from_mm == Approx(0.05).margin(1e-3));
  CHECK(out[0].to_mm == Approx(0.12).margin(1e-3));
  CHECK(out[1].to_mm == Approx(0.35).margin(1e-3));
  CHECK(g.at(cell(5.6, 0.1), 0.01) == Material::kB);  // support below
  CHECK(g.at(cell(5.6, 0.1), 0.2) == Material::kB);   // and in the bore
  CHECK(g.spans(cell(-5.6, 0.1)).empty());            // no pipe on the other side
}

TEST_CASE("Heights below the substrate and above the block count as its lowest and highest") {
  const GridSpec g{2, 1};
  const Geometry m(g, 0.4, {{{0.0, 0.1}, {0.3, 0.4}}, {{0.1, 0.2}}});
  CHECK(m.at(0, -0.5) == Material::kA);
  CHECK(m.at(0, 0.1) == Material::kB);
  CHECK(m.at(0, 0.3) == Material::kA);
  CHECK(m.at(0, 0.4) == Material::kA);
  CHECK(m.at(0, 9.0) == Material::kA);
  CHECK(m.at(1, -0.5) == Material::kB);
  CHECK(m.at(1, 0.15) == Material::kA);
  CHECK(m.at(1, 9.0) == Material::kB);
}

TEST_CASE("A geometry's bytes read back, and damage is named with its byte") {
  const Geometry g = Geometry::sampled(*make_solid(junction(), kGrid), kGrid, 0.4, 0.004);
  const std::vector<std::byte> bytes = to_bytes(g);
  CHECK(geometry_from_bytes(bytes, kGrid, "geometry") == g);
  CHECK_THROWS_WITH(geometry_from_bytes(bytes, GridSpec{60, 41, 0.25, 0.3, 1.0, -2.0}, "geometry"),
                    Catch::Contains("60 x 40 is not the experiment's 60 x 41"));
  for (std::size_t n = 0; n < bytes.size(); n += 1 + n / 7)
    CHECK_THROWS_AS(geometry_from_bytes(std::span(bytes).first(n), kGrid, "geometry"), std::invalid_argument);
  std::vector<std::byte> longer = bytes;
  longer.push_back(std::byte{0});
  CHECK_THROWS_WITH(geometry_from_bytes(longer, kGrid, "geometry"), Catch::Contains("left over"));
  RandomStream random(8, Purpose::kTest);
  for (int n = 0; n < 300; ++n) {  // flipped bits: another geometry or a named error, never a crash
    std::vector<std::byte> bad = bytes;
    bad[random.below(std::uint32_t(bad.size()))] ^= std::byte(1u << random.below(8));
    try {
      geometry_from_bytes(bad, kGrid, "geometry");
    } catch (const std::invalid_argument& e) {
      CHECK(std::string(e.what()).find("geometry: byte ") == 0);
    }
  }
}

TEST_CASE("Geometries and solids that cannot be are refused by cell or field") {
  const GridSpec g{2, 1};
  CHECK_THROWS_WITH(Geometry(g, 0.4, {{{0.2, 0.1}}, {}}), Catch::Contains("cell (0, 0)"));
  CHECK_THROWS_WITH(Geometry(g, 0.4, {{}, {{0.1, 0.3}, {0.2, 0.4}}}), Catch::Contains("cell (1, 0)"));
  CHECK_THROWS_WITH(Geometry(g, 0.4, {{}, {{0.1, 0.5}}}), Catch::Contains("outside 0 .. 0.4"));
  CHECK_THROWS_WITH(Geometry(g, 0.4, {{}}), Catch::Contains("1 columns"));
  CHECK_THROWS_AS(Geometry(g, std::nan(""), {{}, {}}), std::invalid_argument);
  SolidSpec bad = junction();
  bad.branch_bore_width_mm = 6.0;
  CHECK_THROWS_WITH(make_solid(bad, kGrid), Catch::Contains("branch_bore_width_mm"));
  bad = junction();
  bad.inner_diameter_mm = 7.0;
  CHECK_THROWS_WITH(make_solid(bad, kGrid), Catch::Contains("inner_diameter_mm"));
  bad.kind = "klein_bottle";
  CHECK_THROWS_WITH(make_solid(bad, kGrid), Catch::Contains("klein_bottle"));
  CHECK_THROWS_AS(Geometry::sampled(*make_solid(junction(), kGrid), kGrid, 0.4, 0.0), std::invalid_argument);
}

TEST_CASE("A stack of images is read bottom to top, one pitch per layer") {
  const GridSpec g{3, 2};
  Mask first(g), second(g), third(g);
  first.at(0, 0) = 1;
  second.at(2, 1) = 1;
  third.at(0, 0) = 1;
  const ImageStack stack(g, 0.1, {first, second, third});
  const Geometry m = Geometry::sampled(stack, g, 0.4, 0.01);
  REQUIRE(m.spans(0).size() == 2);
  CHECK(m.spans(0)[0].from_mm == 0.0);
  CHECK(m.spans(0)[0].to_mm == Approx(0.1).margin(1e-7));
  CHECK(m.spans(0)[1].to_mm == Approx(0.3).margin(1e-7));
  REQUIRE(m.spans(5).size() == 1);
  CHECK(m.spans(5)[0].from_mm == Approx(0.1).margin(1e-7));
  CHECK(m.spans(1).empty());
  CHECK_THROWS_WITH(ImageStack(g, 0.1, {Mask(GridSpec{2, 2})}), Catch::Contains("image 0"));
  CHECK_THROWS_AS(ImageStack(g, 0.0, {first}), std::invalid_argument);
  CHECK_THROWS_AS(ImageStack(g, 0.1, {}), std::invalid_argument);
}

TEST_CASE("A column keeps one segment per run of one ink and names the ink that fills most of a slice") {
  MaterialColumns columns(GridSpec{2, 1});
  columns.add(0, 0.3, Material::kA);
  columns.add(0, 0.2, Material::kA);
  columns.add(0, 0.25, Material::kB);
  columns.add(0, 0.0, Material::kA);
  REQUIRE(columns.column(0).size() == 2);
  CHECK(columns.top_mm(0) == Approx(0.75));
  CHECK(columns.top_mm(1) == 0.0);
  CHECK(columns.at(0, 0.49) == Material::kA);
  CHECK(columns.at(0, 0.51) == Material::kB);
  CHECK(columns.at(0, 0.75) == Material::kNone);
  CHECK(columns.most(0, 0.3, 0.6) == Material::kA);
  CHECK(columns.most(0, 0.45, 0.75) == Material::kB);
  CHECK(columns.most(0, 0.7, 0.9) == Material::kNone);
  CHECK(columns.most(1, 0.0, 0.1) == Material::kNone);
}
