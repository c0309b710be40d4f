#include "report/run/voxels.h"

#include <catch2/catch.hpp>

using namespace firn;
using namespace firn::report;

namespace {

const GridSpec kVoxelGrid{9, 9};
constexpr double kSlice = 0.01;

// A box of 5 x 5 cells, from 2 to 7 slices up, in a block of 9.
Geometry box() {
  std::vector<std::vector<Span>> spans(kVoxelGrid.size());
  for (int j = 2; j < 7; ++j)
    for (int i = 2; i < 7; ++i) spans[kVoxelGrid.index(i, j)] = {{0.02, 0.07}};
  return Geometry(kVoxelGrid, 0.09, spans);
}

MaterialColumns print_of(const Geometry& g, double raised_mm) {
  MaterialColumns m(g.grid());
  for (std::size_t c = 0; c < g.grid().size(); ++c)
    for (int k = 0; k < 90; ++k) m.add(c, 0.001, g.at(c, (k + 0.5) * 0.001 - raised_mm));
  return m;
}

}  // namespace

TEST_CASE(
    "A block printed as wanted has no wrong voxel, and its boundary layer is the voxels that touch the other "
    "kind") {
  const Geometry g = box();
  const MaterialColumns m = print_of(g, 0.0);
  const int nz = report::slices_for(m, g, kSlice);
  REQUIRE(nz == 10);
  const report::WrongVoxels w =
      report::count_wrong(report::voxels_of(g, kSlice, nz), report::voxels_of(m, kSlice, nz));
  CHECK(w.object == 3 * 3 * 3);
  CHECK(w.object_boundary == 5 * 5 * 5 - 3 * 3 * 3);
  CHECK(w.wrong() == 0);
  CHECK(w.boundary_wrong() == 0);
}

TEST_CASE("A part one slice too high is wrong in the boundary layer only, two slices too high also beyond") {
  const Geometry g = box();
  const report::VoxelBlock wanted = report::voxels_of(g, kSlice, 9);
  const report::WrongVoxels one =
      report::count_wrong(wanted, report::voxels_of(print_of(g, 0.01), kSlice, 9));
  CHECK(one.wrong() == 0);
  CHECK(one.boundary_inside == 25);
  CHECK(one.boundary_outside == 25);
  const report::WrongVoxels two =
      report::count_wrong(wanted, report::voxels_of(print_of(g, 0.02), kSlice, 9));
  CHECK(two.boundary_inside == 25 + 16);  // the second slice's rim touches the support beside it
  CHECK(two.inside == 9);
  CHECK(two.boundary_outside == 25);
  CHECK(two.outside == 25);
}

TEST_CASE("Washing frees what support can reach from outside and leaves the object in its pieces") {
  MaterialColumns m(kVoxelGrid);
  for (std::size_t c = 0; c < kVoxelGrid.size(); ++c) {
    const int i = int(c) % 9, j = int(c) / 9;
    const bool shell = i >= 2 && i <= 6 && j >= 2 && j <= 6, core = i >= 3 && i <= 5 && j >= 3 && j <= 5;
    for (int k = 0; k < 7; ++k) {
      const bool walled =
          shell && (!core || k == 0 || k == 4);  // a closed box of 5 x 5 x 5 round 3 x 3 x 3 of support
      m.add(c, kSlice, walled && k < 5 ? Material::kA : Material::kB);
    }
  }
  report::VoxelBlock v = report::voxels_of(m, kSlice, 7);
  v.cells[0] = Material::kA;  // a loose voxel
  const report::Washed shut = report::wash(v);
  CHECK(shut.object == 125 - 27 + 1);
  CHECK(shut.largest_piece == 125 - 27);
  CHECK(shut.support == 9 * 9 * 7 - shut.object);
  CHECK(shut.support_shut_in == 27);
  v.cells[4 * 81 + kVoxelGrid.index(4, 4)] = Material::kNone;  // a hole in its lid
  CHECK(report::wash(v).support_shut_in == 0);
}

TEST_CASE("Air inside M and object ink above the block are wrong, and missing support is not") {
  const Geometry g = box();
  MaterialColumns m = print_of(g, 0.0);
  const std::size_t c = kVoxelGrid.index(0, 0);
  m.add(c, 0.02, Material::kA);  // on the support's top
  const int nz = report::slices_for(m, g, kSlice);
  CHECK(nz == 11);
  CHECK(report::count_wrong(report::voxels_of(g, kSlice, nz), report::voxels_of(m, kSlice, nz)).outside == 2);
  const report::WrongVoxels nothing = report::count_wrong(
      report::voxels_of(g, kSlice, 9), report::voxels_of(MaterialColumns(kVoxelGrid), kSlice, 9));
  CHECK(nothing.inside + nothing.boundary_inside == 125);
  CHECK(nothing.outside + nothing.boundary_outside == 0);
  CHECK_THROWS_AS(report::count_wrong(report::voxels_of(g, kSlice, 9), report::voxels_of(m, kSlice, 8)),
                  std::invalid_argument);
}
