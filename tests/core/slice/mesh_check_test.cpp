#include <catch2/catch.hpp>

#include "core/slice/mesh/mesh_check.h"
#include "core/slice/mesh/placement.h"
#include "tests/core/slice/meshes.h"

using namespace firn;
using namespace firn::slice;
using namespace firn::test;

namespace {

MeshCheck checked(const SampleMesh& m) { return check(weld(view(m), place(view(m), {}, serially))); }

}  // namespace

TEST_CASE("A closed mesh has no border, and Euler's number tells its holes") {
  const MeshCheck ring = checked(unwelded(torus(20, 7, 40, 20)));
  CHECK(ring.vertices - ring.edges + ring.facets == 0);
  CHECK((ring.border_edges == 0 && ring.branching_edges == 0 && ring.against_edges == 0 && ring.bodies == 1));
  const MeshCheck shells = checked(nested_shells());
  CHECK(shells.bodies == 3);
  CHECK(shells.vertices + shells.facets - shells.edges == 6);
  CHECK(checked(box(0, 0, 0, 1, 2, 3)).area_mm2 == Approx(22.0));
}

TEST_CASE("Borders, branches, facets against the rest and doubles are counted") {
  SampleMesh m = box(0, 0, 0, 4, 4, 4);
  m.triangles.pop_back();
  CHECK(checked(m).border_edges == 3);
  m = box(0, 0, 0, 4, 4, 4);
  std::swap(m.triangles[0][0], m.triangles[0][1]);
  CHECK(checked(m).against_edges == 3);
  m = box(0, 0, 0, 4, 4, 4);
  m.triangles.push_back(m.triangles[3]);
  CHECK(checked(m).duplicate_facets == 1);
  CHECK(checked(m).branching_edges == 3);
  CHECK(checked(both(box(0, 0, 0, 4, 4, 4), box(4, 0, 0, 8, 4, 4))).branching_edges ==
        5);  // a wall in common: four sides and its diagonal
  const MeshCheck strip = checked(moebius());
  CHECK(strip.border_edges == 240);
  CHECK(strip.vertices - strip.edges + strip.facets == 0);
}
