// From meshes made in code to paths: their coverage, and the cost of large parts.
#include <catch2/catch.hpp>

#include "core/geometry/planar.h"
#include "core/slice/coverage/coverage.h"
#include "core/slice/mesh/slicer.h"
#include "core/slice/paths/path_plan.h"
#include "core/slice/support/scaffold.h"
#include "tests/core/slice/coverage_oracle.h"
#include "tests/core/slice/meshes.h"
#include "tests/core/slice/outlines.h"

namespace firn::slice {
namespace {

struct NamedMesh {
  std::string name;
  test::SampleMesh mesh;
};

std::vector<NamedMesh> meshes() {
  return {{"torus", test::torus(22, 7, 60, 24)},    {"gear", test::gear(12, 12.0f, 22.0, 17.0)},
          {"nested shells", test::nested_shells()}, {"44 spheres that run into each other", test::spheres()},
          {"Moebius strip", test::moebius()},       {"T-junctions", test::t_junctions()}};
}

TEST_CASE("Meshes made in code, broken ones too: no uncovered spot wider than a path, in part and scaffold") {
  for (const NamedMesh& m : meshes()) {
    const std::vector<geometry::Region> part = slice(test::view(m.mesh), {}, {}, serially).layers;
    const std::vector<geometry::Region> scaffold = scaffold_regions(part, 2500, {}, 0.05);
    std::size_t seen = 0;
    for (std::size_t k = 1; k < part.size(); k += 11) {
      const LayerRegions regions{
          std::int32_t(k + 1), std::int32_t(k + 1) * 2500, 2500, {part[k], scaffold[k]}};
      const LayerPaths paths = plan_layer(regions, {});
      const std::vector<Coverage> covered = coverage(regions, paths, {}, 0.1);
      for (std::uint8_t material : {std::uint8_t{0}, std::uint8_t{1}}) {
        INFO(m.name << ", layer " << k + 1 << ", material " << int(material));
        const oracle::Spot spot =
            oracle::widest_spot(regions.by_material[material], material ? 0.45 : -0.15, paths, material, 0.1);
        INFO("at " << spot.at_mm.x << ", " << spot.at_mm.y);
        CHECK(spot.widest_mm <= 1.5);
        CHECK(covered[material].widest_gap_mm <= 1.5);
        CHECK(covered[material].gap_mm2 == Approx(spot.gap_mm2).margin(0.02 * spot.wanted_mm2 + 1));
        seen += spot.wanted_mm2 > 0;
      }
    }
    INFO(m.name);
    CHECK(seen > 3);
  }
}

TEST_CASE(
    "A plate of five metres has four points to a ring and no bead between: straight edges cost nothing by "
    "their length") {
  geometry::Region plate;
  outlines::add_box(plate, 0, 0, 5000, 400);
  const LayerRegions regions{1, 2500, 2500, {plate}};
  const LayerPaths paths = plan_layer(regions, {});
  std::size_t beads = 0;
  for (const PathInfo& info : paths.info) beads += !info.closed;
  CHECK(beads <= 1);
  CHECK(paths.lines.points.size() <= 4 * paths.lines.size() + 2);
  CHECK(paths.lines.size() >= 66);
  // Wavy edges: points and beads grow with the edge, not with its length times itself.
  std::vector<std::pair<double, double>> wavy;
  for (int i = 0; i <= 5000; ++i) wavy.push_back({i, 5 * std::sin(0.1 * i)});
  for (int i = 5000; i >= 0; --i) wavy.push_back({i, 60 + 3 * std::sin(0.13 * i)});
  geometry::Region wave;
  outlines::add_polygon(wave, wavy);
  const LayerPaths waves = plan_layer({1, 2500, 2500, {wave}}, {});
  CHECK(waves.lines.points.size() <= 12 * wave.points.size());
  CHECK(waves.clipper_rings == 0);
}

TEST_CASE("Coverage of square metres widens its lines' pitch, says so, and keeps its areas") {
  geometry::Region plate;
  outlines::add_box(plate, 0, 0, 3000, 3000);
  outlines::add_box(plate, 100, 100, 700, 2900, true);
  const LayerRegions regions{1, 2500, 2500, {plate}};
  const LayerPaths paths = plan_layer(regions, {});
  const Coverage c = coverage(regions, paths, {}, 0.1)[0];
  CHECK(c.pitch_mm > 0.2);
  CHECK(c.pitch_mm < 2.0);
  CHECK(c.wanted_mm2 == Approx(3000.3 * 3000.3 - 599.7 * 2799.7).epsilon(1e-3));
  CHECK(c.swept_mm2 - c.beyond_mm2 + c.gap_mm2 == Approx(c.wanted_mm2).epsilon(1e-9));
  CHECK(c.gap_mm2 < 0.01 * c.wanted_mm2);
  geometry::Region small;
  outlines::add_box(small, 0, 0, 30, 30);
  const LayerRegions box{1, 2500, 2500, {small}};
  CHECK(coverage(box, plan_layer(box, {}), {}, 0.1)[0].pitch_mm == 0.1);
}

}  // namespace
}  // namespace firn::slice
