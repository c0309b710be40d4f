// Layers of the meshes of ../shared/models, which stay outside the repository, or of their stand-ins.
#include <catch2/catch.hpp>

#include <cmath>
#include <filesystem>

#include "core/geometry/planar.h"
#include "core/slice/mesh/slicer.h"
#include "files/mesh/mesh_file.h"
#include "tests/core/slice/models.h"
#include "tests/core/slice/oracles.h"

using namespace firn;
using namespace firn::slice;

namespace {

Sliced sliced(const std::filesystem::path& file, double tolerance_mm) {
  const MeshFile mesh(file);
  SliceOptions o;
  o.chord_tolerance_mm = tolerance_mm;
  Placement p;
  for (AxisPlace& t : p.translation) t.mode = AxisPlace::Mode::kNumber;
  return slice::slice(mesh.facets(), p, o, serially);
}

}  // namespace

TEST_CASE("Every real model slices into rings that cross nowhere, at tolerance 0.05 mm and with all points") {
  for (const char* name :
       {"rocker_20k.ply", "bunny_69k.ply", "armadillo_86k.ply", "igea_269k.ply", "lucy500_15k.ply"}) {
    const std::filesystem::path file = firn::test::model_file(name);
    for (const double tolerance : {0.0, 0.05}) {
      INFO(name << ", tolerance " << tolerance);
      const Sliced s = sliced(file, tolerance);
      CHECK(s.layers.size() >= 658);
      double volume = 0.0;
      RandomStream random(31, Purpose::kTest);
      const std::uint32_t looked_at = random.below(97);
      for (std::size_t n = 0; n < s.layers.size(); ++n) {
        INFO("layer " << n + 1);
        volume += 0.25 * area_mm2(s.layers[n]);
        if (s.facts.closed) CHECK_FALSE(s.layers[n].empty());
        if (n % 97 == looked_at && tolerance > 0.0)
          CHECK(firn::test::crossing_by_all_pairs(s.layers[n]) == "");
        CHECK(region_of(s.layers[n]).points.size() >= s.layers[n].points.size());
      }
      if (s.facts.closed) {
        CHECK(std::abs(volume / s.facts.volume_mm3 - 1.0) <= 1e-3);
        for (const Defect& d : s.defects) CHECK(d.kind == DefectKind::kOverlap);
      }
    }
  }
}

TEST_CASE(
    "Areas of random layers of the real models agree with rows of 0.025 mm over the facets themselves") {
  RandomStream random(32, Purpose::kTest);
  for (const char* name : {"rocker_20k.ply", "armadillo_86k.ply", "igea_269k.ply", "lucy500_15k.ply"}) {
    const std::filesystem::path file = firn::test::model_file(name);
    const MeshFile mesh(file);
    const firn::test::SampleMesh facets{mesh.data().vertices, mesh.data().triangles};
    const Sliced all = sliced(file, 0.0), few = sliced(file, 0.05);
    for (int k = 0; k < 3; ++k) {
      const std::size_t n = random.below(std::uint32_t(all.layers.size()));
      INFO(name << ", layer " << n + 1);
      const double area = firn::test::Section(facets, (double(n) + 0.5) * 0.25 + 0.00005).area(0.025);
      CHECK(area_mm2(all.layers[n]) == Approx(area).epsilon(5e-4));
      CHECK(area_mm2(few.layers[n]) == Approx(area).epsilon(3e-3));
    }
  }
}

TEST_CASE("The bunny's holes are told with layer and place, and no layer loses its outline") {
  const Sliced s = sliced(firn::test::model_file("bunny_69k.ply"), 0.05);
  CHECK_FALSE(s.facts.closed);
  int base = 0, belly = 0;
  for (const Defect& d : s.defects) {
    if (d.kind != DefectKind::kGapClosed && d.kind != DefectKind::kOpenDropped) continue;
    CHECK((d.layer <= 40 || (d.layer > 95 && d.layer < 125)));  // the holes in the base and at z = 29 mm
    (d.layer <= 40 ? base : belly) += 1;
  }
  CHECK(base > 20);
  CHECK(belly > 10);
  for (std::size_t n = 95; n < 125; ++n) CHECK(area_mm2(s.layers[n]) > 5'000.0);
}
