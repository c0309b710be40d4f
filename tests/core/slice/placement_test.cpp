#include <catch2/catch.hpp>

#include <cmath>

#include "core/slice/mesh/placement.h"
#include "tests/core/slice/oracles.h"

using namespace firn;
using namespace firn::slice;
using namespace firn::test;
using Mode = AxisPlace::Mode;

namespace {

Affine placed(const SampleMesh& m, const Placement& p) { return place(view(m), p, serially); }

SampleMesh off_centre() { return box(10, 20, 30, 14, 26, 38); }  // 4 x 6 x 8 mm

}  // namespace

TEST_CASE("Without scale, rotation and translation a part stays where the file has it") {
  const Affine a = placed(off_centre(), {});
  CHECK(a.low == Vertex{100'000, 200'000, 300'000});
  CHECK(a.high == Vertex{140'000, 260'000, 380'000});
}

TEST_CASE(
    "A number is the smallest coordinate, cent centres, orig keeps the middle [Barnett, Table 3-1, note b]") {
  Placement p;
  p.scale = {2, 2, 2};
  p.translation[0] = {Mode::kNumber, 5.0};
  p.translation[1] = {Mode::kCentre, 0.0};
  p.translation[2] = {Mode::kOriginal, 0.0};
  const Affine a = placed(off_centre(), p);
  CHECK(a.low == Vertex{50'000, -60'000, 260'000});
  CHECK(a.high == Vertex{130'000, 60'000, 420'000});
}

TEST_CASE("A part that is scaled or turned is first moved to 0 [Barnett, 3.1.2]") {
  Placement p;
  p.scale = {1, 1, 0.5};
  const Affine a = placed(off_centre(), p);
  CHECK(a.low == Vertex{0, 0, 0});
  CHECK(a.high == Vertex{40'000, 60'000, 40'000});
}

TEST_CASE("Rotations turn about space-fixed axes, one at a time, in the order given [Barnett, 3.1.2]") {
  Placement p;
  p.rotation_deg = {90, 0, 90};  // x then z: y -> z -> z; x -> x -> y
  Affine a = placed(off_centre(), p);
  CHECK(a.high.x - a.low.x == 80'000);  // z -> -y -> x
  CHECK(a.high.y - a.low.y == 40'000);
  CHECK(a.high.z - a.low.z == 60'000);
  p.order = {2, 1, 0};  // z then x
  a = placed(off_centre(), p);
  CHECK(a.high.x - a.low.x == 60'000);
  CHECK(a.high.y - a.low.y == 80'000);
  CHECK(a.high.z - a.low.z == 40'000);
}

TEST_CASE("A quarter turn is exact, any turn keeps lengths") {
  Placement p;
  p.rotation_deg = {-85, 0, 0};  // the thesis's statue
  p.translation[2] = {Mode::kNumber, 0.0};
  const Affine a = placed(off_centre(), p);
  const double c = std::cos(85 * M_PI / 180), s = std::sin(85 * M_PI / 180);
  CHECK(a.low.z == 0);
  CHECK(std::abs(a.high.z - (6 * s + 8 * c) * geometry::kUnitsPerMm) <= 1.0);
  CHECK(std::abs((a.high.y - a.low.y) - (6 * c + 8 * s) * geometry::kUnitsPerMm) <= 1.0);
}

TEST_CASE("Units scale, mirrors keep the material inside") {
  Placement p;
  p.unit_mm = 25.4;
  CHECK(placed(box(0, 0, 0, 1, 1, 1), p).high == Vertex{254'000, 254'000, 254'000});
  p.unit_mm = 1.0;
  p.scale = {-1, 1, 1};
  const Affine a = placed(off_centre(), p);
  CHECK(a.mirrors);
  CHECK(a.high.x == 0);
  CHECK(a.low.x == -40'000);
}

TEST_CASE("A part of nothing but broken corners has no box") {
  SampleMesh m;
  m.vertices = {{NAN, 0, 0}, {0, INFINITY, 0}, {0, 0, 1}};
  m.triangles = {{0, 1, 2}};
  const Affine a = placed(m, {});
  CHECK(a.not_finite == 1);
  CHECK(a.low.x > a.high.x);
}

TEST_CASE("Placements that make no sense are refused by name") {
  Placement p;
  p.unit_mm = 0.0;
  CHECK_THROWS_WITH(placed(off_centre(), p), Catch::Contains("unit"));
  p = {};
  p.scale[1] = 0.0;
  CHECK_THROWS_WITH(placed(off_centre(), p), Catch::Contains("scale[1]"));
  p = {};
  p.rotation_deg[2] = NAN;
  CHECK_THROWS_WITH(placed(off_centre(), p), Catch::Contains("rotation_deg[2]"));
  p = {};
  p.order = {0, 0, 1};
  CHECK_THROWS_WITH(placed(off_centre(), p), Catch::Contains("order"));
  p = {};
  p.translation[0] = {Mode::kNumber, INFINITY};
  CHECK_THROWS_WITH(placed(off_centre(), p), Catch::Contains("translation[0]"));
  p = {};
  p.unit_mm = 1000.0;
  CHECK_THROWS_WITH(placed(box(0, 0, 0, 200, 1, 1), p), Catch::Contains("axis x"));
}
