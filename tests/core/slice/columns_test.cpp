#include <catch2/catch.hpp>

#include <cmath>

#include "core/slice/mesh/columns.h"
#include "core/slice/mesh/placement.h"
#include "tests/core/slice/oracles.h"

using namespace firn;
using namespace firn::slice;
using namespace firn::test;

namespace {

Mesh welded(const SampleMesh& m) { return weld(view(m), place(view(m), {}, serially)); }

bool covered(const std::vector<Span>& spans, double z) {
  for (const Span& s : spans)
    if (s.from_mm <= z && z < s.to_mm) return true;
  return false;
}

}  // namespace

TEST_CASE("Columns of a mesh hold the heights at which its facets wind round the cell's centre") {
  const GridSpec grid{25, 23, 1.31, 1.27, -14.0, -13.0};
  for (const SampleMesh& m : {nested_shells(), torus(10, 4, 60, 30), moved(spheres(20, 4), -15, -15, 0)}) {
    const auto spans = columns(welded(m), grid, 30.0);
    std::size_t in = 0, differ = 0;
    for (double z = 0.137; z < 30.0; z += 0.71) {
      const Section section(m, z);
      for (int j = 0; j < grid.ny; ++j)
        for (int i = 0; i < grid.nx; ++i) {
          const bool inside = section.winding(grid.x_mm(i), grid.y_mm(j)) > 0;
          in += inside;
          differ += inside != covered(spans[grid.index(i, j)], z);
        }
    }
    CHECK(in > 500);
    CHECK(differ <= 1);  // a centre within a unit of the surface
  }
}

TEST_CASE("Cell centres on edges and corners of a mesh are counted once") {
  const GridSpec grid{7, 7, 1.0, 1.0, -1.0, -1.0};  // centres on the box's corners, edges and facet diagonals
  const auto spans = columns(welded(box(0, 0, 0.5f, 4, 4, 2)), grid, 10.0);
  std::size_t cells = 0;
  for (const std::vector<Span>& s : spans) {
    REQUIRE(s.size() <= 1);
    if (s.empty()) continue;
    ++cells;
    CHECK(s[0] == Span{0.5, 2.0});
  }
  CHECK(cells == 16);  // half-open: a centre on the low sides is in, one on the high sides is out
}

TEST_CASE("Columns are cut at the substrate and at the block's top") {
  const GridSpec grid{1, 1, 1.0, 1.0, 0.0, 0.0};
  const auto spans = columns(welded(box(-2, -2, -5, 2, 2, 50)), grid, 7.5);
  CHECK(spans[0] == std::vector<Span>{{0.0, 7.5}});
  CHECK(columns(welded(box(-2, -2, 8, 2, 2, 50)), grid, 7.5)[0].empty());
}

TEST_CASE("A mesh as a Solid answers as its columns do") {
  const SampleMesh m = nested_shells();
  const MeshSolid solid(welded(m));
  RandomStream random(41, Purpose::kTest);
  int in = 0;
  for (int k = 0; k < 2'000; ++k) {
    const double x = random.uniform(-13, 13), y = random.uniform(-13, 13), z = random.uniform(-1, 25);
    const bool inside = Section(m, z).winding(x, y) > 0;
    in += inside;
    REQUIRE(solid.contains(x, y, z) == inside);
  }
  CHECK(in > 300);
  CHECK_FALSE(MeshSolid(Mesh{}).contains(0, 0, 0));
}

TEST_CASE("Welding gives each grid point one vertex, in linear time and in the order of use") {
  const SampleMesh m = torus(10, 4, 60, 30);
  const Mesh mesh = welded(unwelded(m));
  CHECK(mesh.vertices.size() == 60 * 30);
  CHECK(mesh.triangles.size() == m.triangles.size());
  CHECK(mesh.triangles[0] == std::array<std::uint32_t, 3>{0, 1, 2});
  CHECK(welded(with_nan()).triangles.size() == 12);
}
