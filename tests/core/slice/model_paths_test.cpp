// Paths of the real meshes of ../shared/models, where they are; they stay outside the repository.
#include <catch2/catch.hpp>

#include <cmath>
#include <filesystem>
#include <optional>

#include "cli/mesh_file.h"
#include "core/slice/coverage.h"
#include "core/slice/offset_rings.h"
#include "core/slice/path_plan.h"
#include "core/slice/planar.h"
#include "core/slice/scaffold.h"
#include "core/slice/slicer.h"
#include "tests/core/slice/offset_oracle.h"

namespace firn::slice {
namespace {

std::vector<Region> layers_of(const std::string& name, const SliceOptions& options = {}) {
  for (const char* folder : {"/../shared/models/", "/../../shared/models/"}) {
    const std::filesystem::path file = std::string(FIRN_SOURCE_DIR) + folder + name;
    if (!std::filesystem::exists(file)) continue;
    const MeshFile mesh(file);
    return slice(mesh.facets(), {}, options, serially).layers;
  }
  WARN("shared/models/" << name << " is not beside the source tree: skipped");
  return {};
}

TEST_CASE("Rings of real layers lie within 0.05 mm of the exact offset of the original outline, both ways") {
  for (const char* name : {"rocker_20k.ply", "bunny_69k.ply", "armadillo_86k.ply", "igea_269k.ply", "lucy500_15k.ply"}) {
    const std::vector<Region> layers = layers_of(name);
    for (std::size_t k = 40; k < layers.size(); k += 290) {
      const RingPlan plan;
      const RingLevels rings = offset_rings(layers[k], plan, 0.05);
      for (int level = 0; level < int(rings.levels.size()); level += 2) {
        INFO(name << ", layer " << k + 1 << ", level " << level);
        const double step = 400, d = plan.distance_mm(level) * kUnitsPerMm;
        const oracle::Hausdorff h = oracle::hausdorff(layers[k], rings.levels[std::size_t(level)], d, step, 3000);
        CHECK(h.exact_to_ring <= 501);
        CHECK(h.ring_to_exact <= std::hypot(501, step));
      }
    }
  }
}

TEST_CASE("From the outline before PATHFILTER, rings run at their distance to within both tolerances added up") {
  double worst = 0;
  for (const char* name : {"rocker_20k.ply", "armadillo_86k.ply", "igea_269k.ply"}) {
    const std::vector<Region> layers = layers_of(name), original = layers_of(name, {.chord_tolerance_mm = 0});
    for (std::size_t k = 50; k < layers.size(); k += 150) {
      const RingPlan plan;
      const RingLevels rings = offset_rings(layers[k], plan, 0.05);
      for (int level = 0; level < int(rings.levels.size()); ++level) {
        INFO(name << ", layer " << k + 1 << ", level " << level);
        const double d = plan.distance_mm(level) * kUnitsPerMm;
        const oracle::Nearby outline(oracle::segments_of(original[k]), d + 2000);
        for (const Vec p : oracle::along(rings.levels[std::size_t(level)], 800)) {
          const double off = std::abs(outline.distance_to(p) - d);
          worst = std::max(worst, off);
          CHECK(off <= 1001);
        }
      }
    }
  }
  INFO("largest " << worst * kMmPerUnit << " mm");
  CHECK(worst <= 1001);
}

TEST_CASE("No path of a real model crosses or touches another of its kind, and none needed Clipper") {
  for (const char* name : {"rocker_20k.ply", "bunny_69k.ply", "armadillo_86k.ply", "igea_269k.ply"}) {
    const std::vector<Region> layers = layers_of(name);
    const std::vector<Region> scaffold = scaffold_regions(layers, 2500, {}, 0.05);
    for (std::size_t k = 0; k < layers.size(); k += 3) {
      INFO(name << ", layer " << k + 1);
      CHECK(simple_and_apart(scaffold[k]));
      const LayerPaths paths = plan_layer({std::int32_t(k + 1), std::int32_t(k + 1) * 2500, 2500, {layers[k], scaffold[k]}}, {});
      Rings rings;  // beads in gaps are open lines
      for (std::size_t i = 0; i < paths.info.size(); ++i)
        if (paths.info[i].closed) rings.add(paths.lines[i]);
      CHECK(simple_and_apart(rings));
      CHECK(paths.clipper_rings == 0);
    }
  }
}

TEST_CASE("What the beads of a real model cover, overlaps taken off, is what they are to cover but for spots narrower than a path") {
  for (const char* name : {"rocker_20k.ply", "bunny_69k.ply", "armadillo_86k.ply", "igea_269k.ply", "lucy500_15k.ply"}) {
    const std::vector<Region> layers = layers_of(name);
    const std::vector<Region> scaffold = scaffold_regions(layers, 2500, {}, 0.05);
    for (std::size_t k = 60; k < layers.size(); k += 190) {
      INFO(name << ", layer " << k + 1);
      const LayerRegions regions{std::int32_t(k + 1), std::int32_t(k + 1) * 2500, 2500, {layers[k], scaffold[k]}};
      const std::vector<Coverage> covered = coverage(regions, plan_layer(regions, {}), {}, 0.2);
      REQUIRE(covered.size() == 2);
      for (const Coverage& c : covered) {
        CHECK(c.widest_gap_mm <= 1.5);
        CHECK(c.beyond_mm2 <= 0.02 * c.wanted_mm2 + 1);
      }
      if (covered[0].wanted_mm2 > 500) CHECK(covered[0].gap_mm2 <= 0.15 * covered[0].wanted_mm2);
    }
  }
}

}  // namespace
}  // namespace firn::slice
