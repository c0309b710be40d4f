// Paths of the meshes of ../shared/models, which stay outside the repository, or of their stand-ins.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>

#include "core/geometry/planar.h"
#include "core/slice/coverage/coverage.h"
#include "core/slice/mesh/slicer.h"
#include "core/slice/offset/offset_rings.h"
#include "core/slice/paths/path_plan.h"
#include "core/slice/support/scaffold.h"
#include "files/mesh/mesh_file.h"
#include "tests/core/slice/coverage_oracle.h"
#include "tests/core/slice/models.h"
#include "tests/core/slice/offset_oracle.h"
#include "tests/support/long_cases.h"

namespace firn::slice {
namespace {

std::vector<geometry::Region> layers_of(const std::string& name, const SliceOptions& options = {}) {
  const MeshFile mesh(test::model_file(name));
  return slice(mesh.facets(), {}, options, serially).layers;
}

TEST_CASE("Rings of real layers lie within 0.05 mm of the exact offset of the original outline, both ways") {
  for (const char* name :
       {"rocker_20k.ply", "bunny_69k.ply", "armadillo_86k.ply", "igea_269k.ply", "lucy500_15k.ply"}) {
    const std::vector<geometry::Region> layers = layers_of(name);
    for (std::size_t k = 40; k < layers.size(); k += 290) {
      const RingPlan plan;
      const RingLevels rings = offset_rings(layers[k], plan, 0.05);
      for (int level = 0; level < int(rings.levels.size()); level += 2) {
        INFO(name << ", layer " << k + 1 << ", level " << level);
        const double step = 400, d = plan.distance_mm(level) * geometry::kUnitsPerMm;
        const oracle::Hausdorff h =
            oracle::hausdorff(layers[k], rings.levels[std::size_t(level)], d, step, 3000);
        CHECK(h.exact_to_ring <= 501);
        CHECK(h.ring_to_exact <= std::hypot(501, step));
      }
    }
  }
}

// Rings of layers of a model, for a chord tolerance of 0.05 mm shared with PATHFILTER, against the exact
// offset of its contours.
template <class Layers>
void check_rings(const char* name, Layers&& next_layer) {
  const double filter_mm = kOutlineShare * 0.05, ring_mm = kRingShare * 0.05;
  const std::vector<geometry::Region> layers = layers_of(name, {.chord_tolerance_mm = filter_mm}),
                                      original = layers_of(name, {.chord_tolerance_mm = 0});
  for (std::size_t k = next_layer(0); k < layers.size(); k = next_layer(k)) {
    const RingPlan plan;
    const RingLevels rings = offset_rings(layers[k], plan, ring_mm, 0, {&original[k], filter_mm, true});
    for (int level = 0; level < int(rings.levels.size()); ++level) {
      INFO(name << ", layer " << k + 1 << ", level " << level);
      const double step = 250, d = plan.distance_mm(level) * geometry::kUnitsPerMm;
      const oracle::Nearby outline(oracle::segments_of(original[k]), d + 2000);
      for (const geometry::Vec p : oracle::along(rings.levels[std::size_t(level)], step))
        CHECK(std::abs(outline.distance_to(p) - d) <= 500);
      const oracle::Hausdorff h =
          oracle::hausdorff(original[k], rings.levels[std::size_t(level)], d, step, 3000);
      CHECK(h.exact_to_ring <= 500);
      CHECK(h.ring_to_exact <= std::hypot(500, 0.5 * step));
    }
  }
}

/// Makes check_rings() look at one layer, counted from 1.
auto only(std::size_t layer) {
  return [=](std::size_t k) { return k == 0 ? layer - 1 : 1'000'000; };
}

TEST_CASE(
    "With the tolerance shared with PATHFILTER, rings lie within 0.05 mm of the exact offset of the mesh's "
    "own contours, both ways") {
  const std::size_t first = test::full_cases() ? 10 : 240, step = test::full_cases() ? 20 : 400;
  for (const char* name : {"rocker_20k.ply", "bunny_69k.ply", "armadillo_86k.ply", "lucy500_15k.ply"})
    check_rings(name, [&](std::size_t k) { return k == 0 ? first : k + step; });
}

TEST_CASE(
    "Tips that do not fit together, and those of areas hardly wider than the thinning, are made again from "
    "finer contours") {
  check_rings("armadillo_86k.ply", only(11));
  check_rings("bunny_69k.ply", only(191));
}

TEST_CASE("Areas and straits that PATHFILTER opens or closes are made again from finer contours") {
  struct Case {
    const char* name;
    std::size_t layer;
  };
  const std::vector<Case> all{
      {"rocker_20k.ply", 140}, {"armadillo_86k.ply", 186}, {"bunny_69k.ply", 43},   {"lucy500_15k.ply", 49},
      {"rocker_20k.ply", 152}, {"armadillo_86k.ply", 545}, {"rocker_20k.ply", 158}, {"lucy500_15k.ply", 337},
      {"rocker_20k.ply", 173}, {"armadillo_86k.ply", 561}, {"rocker_20k.ply", 380}, {"lucy500_15k.ply", 370},
      {"rocker_20k.ply", 637}, {"lucy500_15k.ply", 397}};
  for (const auto& [name, layer] : test::long_cases(all, 4)) check_rings(name, only(layer));
}

TEST_CASE(
    "No spot as wide as the narrower path stays uncovered where an area's tips are lost to the thinning") {
  const double filter_mm = kOutlineShare * 0.05;
  const std::vector<geometry::Region> layers = layers_of("bunny_69k.ply", {.chord_tolerance_mm = filter_mm});
  const std::vector<geometry::Region> original = layers_of("bunny_69k.ply", {.chord_tolerance_mm = 0});
  for (std::size_t k = 9; k < std::min<std::size_t>(layers.size(), 15); ++k) {
    const LayerRegions regions{std::int32_t(k) + 1, 0, 2500, {layers[k]}, original[k], filter_mm, true};
    const oracle::Spot spot = oracle::widest_spot(
        layers[k], 0.6 - 0.75, plan_layer(regions, {.chord_tolerance_mm = kRingShare * 0.05}), 0, 0.1);
    INFO("layer " << k + 1 << ", " << spot.at_mm.x << ", " << spot.at_mm.y);
    CHECK(spot.widest_mm <= 1.5);
  }
}

// Places on a grid that lie inside a region, row by row.
class Raster {
 public:
  Raster(geometry::Vec low, geometry::Vec high, double pitch)
      : low_(low),
        pitch_(pitch),
        nx_(int((high.x - low.x) / pitch) + 1),
        ny_(int((high.y - low.y) / pitch) + 1) {}
  int places() const { return nx_ * ny_; }
  geometry::Vec at(int i) const { return low_ + pitch_ * geometry::Vec{double(i % nx_), double(i / nx_)}; }
  std::vector<bool> inside(const geometry::Region& region) const {
    std::vector<bool> in(std::size_t(places()), false);
    std::vector<std::vector<double>> rows(static_cast<std::size_t>(ny_));
    for (const oracle::Segment& s : oracle::segments_of(region))
      for (int y = std::max(0, int((std::min(s.a.y, s.b.y) - low_.y) / pitch_));
           y < ny_ && low_.y + y * pitch_ <= std::max(s.a.y, s.b.y); ++y)
        if (const double at = low_.y + y * pitch_; (s.a.y <= at) != (s.b.y <= at))
          rows[std::size_t(y)].push_back(s.a.x + (at - s.a.y) / (s.b.y - s.a.y) * (s.b.x - s.a.x));
    for (int y = 0; y < ny_; ++y) {
      std::vector<double>& row = rows[std::size_t(y)];
      std::sort(row.begin(), row.end());
      std::size_t passed = 0;
      for (int x = 0; x < nx_; ++x) {
        while (passed < row.size() && row[passed] <= low_.x + x * pitch_) ++passed;
        in[std::size_t(y * nx_ + x)] = passed % 2;
      }
    }
    return in;
  }

 private:
  geometry::Vec low_;
  double pitch_;
  int nx_, ny_;
};

TEST_CASE(
    "Overhang scaffold of real models: what hangs over has scaffold or part below it down to part or ground, "
    "none is in the part") {
  for (const char* name : {"igea_269k.ply", "armadillo_86k.ply", "bunny_69k.ply"}) {
    const double height_mm = 0.5,
                 lean = height_mm * std::tan(40 * 3.14159265358979 / 180) * geometry::kUnitsPerMm;
    const std::vector<geometry::Region> part = layers_of(name, {.layer_height_mm = height_mm});
    const std::vector<geometry::Region> scaffold = scaffold_regions(
        part, 5000, {.kind = Support::kOverhang, .overhang_rad = 40 * 3.14159265358979 / 180}, 0.05);
    geometry::Vec low{1e300, 1e300}, high{-1e300, -1e300};
    std::size_t points = 0;
    for (const geometry::Region& r : part)
      for (const geometry::Point p : r.points) {
        low = {std::min(low.x, double(p.x)), std::min(low.y, double(p.y))};
        high = {std::max(high.x, double(p.x)), std::max(high.y, double(p.y))};
      }
    const Raster raster(low, high, 7919);
    // From the top: may a place go without scaffold? Not while something hangs over it.
    std::vector<bool> hangs(std::size_t(raster.places()), false), above;
    int checked = 0, lacking = 0, in_part = 0;
    for (std::size_t k = part.size(); k-- > 0;) {
      points += scaffold[k].points.size();
      const std::vector<bool> ice = raster.inside(part[k]), stands = raster.inside(scaffold[k]);
      const oracle::Nearby outline(oracle::segments_of(part[k]), 1.15 * lean + 600);
      for (int i = 0; i < raster.places(); ++i) {
        const std::size_t n = std::size_t(i);
        if (!above.empty() && above[n] && !ice[n] && outline.distance_to(raster.at(i)) > 1.1 * lean + 500)
          hangs[n] = true;
        if (ice[n]) hangs[n] = false;
        // Corners that subtracting makes are rounded to the grid: within a unit of the outline a place may
        // lie in both.
        in_part += ice[n] && stands[n] && outline.distance_to(raster.at(i)) > 1;
        checked += hangs[n];
        lacking += hangs[n] && !stands[n];
      }
      above = ice;
    }
    INFO(name << ": " << checked << " places below overhangs, " << points << " points");
    CHECK(checked > 1000);
    CHECK(lacking == 0);
    CHECK(in_part == 0);
  }
}

TEST_CASE("No path of a real model crosses or touches another of its kind, and none needed Clipper") {
  for (const char* name : {"rocker_20k.ply", "bunny_69k.ply", "armadillo_86k.ply", "igea_269k.ply"}) {
    const std::vector<geometry::Region> layers = layers_of(name);
    const std::vector<geometry::Region> scaffold = scaffold_regions(layers, 2500, {}, 0.05);
    for (std::size_t k = 0; k < layers.size(); k += 3) {
      INFO(name << ", layer " << k + 1);
      CHECK(!first_contact(scaffold[k]));
      const LayerPaths paths =
          plan_layer({std::int32_t(k + 1), std::int32_t(k + 1) * 2500, 2500, {layers[k], scaffold[k]}}, {});
      geometry::Rings rings;  // beads in gaps are open lines
      for (std::size_t i = 0; i < paths.info.size(); ++i)
        if (paths.info[i].closed) rings.add(paths.lines[i]);
      CHECK(!first_contact(rings));
      CHECK(paths.clipper_rings == 0);
    }
  }
}

TEST_CASE(
    "What the beads of a real model cover, overlaps taken off, is what they are to cover but for spots "
    "narrower than a path") {
  for (const char* name :
       {"rocker_20k.ply", "bunny_69k.ply", "armadillo_86k.ply", "igea_269k.ply", "lucy500_15k.ply"}) {
    const std::vector<geometry::Region> layers = layers_of(name);
    const std::vector<geometry::Region> scaffold = scaffold_regions(layers, 2500, {}, 0.05);
    for (std::size_t k = 60; k < layers.size(); k += 190) {
      INFO(name << ", layer " << k + 1);
      const LayerRegions regions{
          std::int32_t(k + 1), std::int32_t(k + 1) * 2500, 2500, {layers[k], scaffold[k]}};
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
