#include "core/slice/medial/gap_fill.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/grid/random.h"
#include "core/slice/paths/path_plan.h"
#include "tests/core/slice/coverage_oracle.h"
#include "tests/core/slice/outlines.h"

namespace firn::slice {
namespace {

// Of material 0 (water) or 1 (SME): the region alone in its layer.
LayerPaths paths_of(const geometry::Region& region, std::uint8_t material, const PathOptions& options) {
  LayerRegions regions{1, 2500, 2500, std::vector<geometry::Region>(material + 1u)};
  regions.by_material[material] = region;
  return plan_layer(regions, options);
}

double inset_mm(std::uint8_t material) { return material ? 1.2 - 0.75 : 0.6 - 0.75; }

std::vector<std::int32_t> gap_widths(const LayerPaths& paths) {
  std::vector<std::int32_t> widths;
  for (const PathInfo& info : paths.info)
    if (!info.closed) widths.push_back(info.width);
  return widths;
}

double wall_length_mm(const LayerPaths& paths) {
  double sum = 0;
  for (std::size_t i = 0; i < paths.info.size(); ++i)
    for (std::size_t p = 1; !paths.info[i].closed && p < paths.lines[i].size(); ++p)
      sum += geometry::kMmPerUnit * length(to_vec(paths.lines[i][p]) - to_vec(paths.lines[i][p - 1]));
  return sum;
}

TEST_CASE("A concentric fill leaves no spot as wide as its narrower path, by a raster of distances") {
  for (const outlines::Named& shape : outlines::all()) {
    for (const std::uint8_t material : {0, 1}) {
      INFO(shape.name << ", material " << int(material));
      const oracle::Spot spot = oracle::widest_spot(shape.region, inset_mm(material),
                                                    paths_of(shape.region, material, {}), material, 0.06);
      CHECK(spot.widest_mm <= 1.5);
      CHECK(spot.gap_mm2 <= 0.1 * spot.wanted_mm2);
    }
  }
}

TEST_CASE(
    "Lines and zigzags leave no spot as wide as the narrower path either: fingers that no line meets have "
    "beads") {
  for (const FillPattern pattern : {FillPattern::kLines, FillPattern::kZigzag}) {
    for (const double angle : {0.0, 0.4}) {
      PathOptions options;
      options.part.pattern = options.scaffold.pattern = pattern;
      options.part.fill_angle_rad = options.scaffold.fill_angle_rad = angle;
      for (const outlines::Named& shape : outlines::all()) {
        for (const std::uint8_t material : {0, 1}) {
          INFO(shape.name << ", material " << int(material) << ", pattern " << int(pattern) << ", angle "
                          << angle);
          const LayerPaths paths = paths_of(shape.region, material, options);
          const oracle::Spot spot =
              oracle::widest_spot(shape.region, inset_mm(material), paths, material, 0.1);
          CHECK(spot.widest_mm <= 1.5);
          CHECK(spot.gap_mm2 <= 0.1 * spot.wanted_mm2);
        }
      }
    }
  }
}

TEST_CASE("Random outlines at random widths: no spot wider than the narrower path") {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    INFO("star " << seed);
    RandomStream random(seed, Purpose::kTest);
    PathOptions options;
    options.part.boundary_width_mm = random.uniform(0.8, 2.0);
    options.part.fill_width_mm = options.part.boundary_width_mm * random.uniform(1.0, 2.0);
    options.part.first_offset_mm = random.uniform(0.3, 1.2) * options.part.boundary_width_mm;
    options.part.boundaries = 1 + int(random.below(3));
    options.part.gap_mm = 0.5 * options.part.boundary_width_mm;
    const double inset = options.part.first_offset_mm - 0.5 * options.part.boundary_width_mm;
    const geometry::Region region =
        seed % 2 ? outlines::random_star(seed, 10 + int(seed), 4, 22) : outlines::blob(seed);
    const oracle::Spot spot = oracle::widest_spot(region, inset, paths_of(region, 0, options), 0, 0.08);
    CHECK(spot.widest_mm <= options.part.boundary_width_mm);
  }
}

TEST_CASE("A wall without room for a second ring gets one bead along its middle, as wide as the gap") {
  geometry::Region wall;
  outlines::add_box(wall, 0, 0, 60, 5.3);
  const LayerPaths paths = paths_of(wall, 0, {});
  // Rings at 0.6 leave 5.3 - 2 x (0.6 + 0.75) = 2.6 mm.
  const std::vector<std::int32_t> widths = gap_widths(paths);
  REQUIRE(widths.size() == 1);
  CHECK(std::abs(widths[0] - 26000) < 20);
  for (std::size_t i = 0; i < paths.info.size(); ++i)
    for (const geometry::Point p : paths.lines[i])
      if (!paths.info[i].closed) CHECK(std::abs(p.y - 26500) < 20);
  CHECK(wall_length_mm(paths) > 60 - 5.3 - 1.0);
  PathOptions none;
  none.part.gap_mm = 0;
  CHECK(gap_widths(paths_of(wall, 0, none)).empty());
  CHECK(oracle::widest_spot(wall, -0.15, paths_of(wall, 0, none), 0, 0.05).widest_mm > 2.5);
}

TEST_CASE("A part thinner than twice its first offset is one bead along its middle: nothing is lost") {
  for (const double width : {0.5, 0.8, 1.19}) {
    INFO("ring " << width << " mm thick");
    geometry::Region ring;
    outlines::add_circle(ring, 0, 0, 12, 90);
    outlines::add_circle(ring, 0, 0, 12 - width, 90, true);
    const LayerPaths paths = paths_of(ring, 0, {});
    for (const std::int32_t w : gap_widths(paths))
      CHECK(std::abs(w * geometry::kMmPerUnit - (width + 0.3)) < 0.05);
    CHECK(wall_length_mm(paths) == Approx(2 * outlines::kPi * (12 - 0.5 * width)).epsilon(0.02));
    for (const PathInfo& info : paths.info) CHECK(info.kind == PathKind::kBoundary);
    CHECK(oracle::widest_spot(ring, -0.15, paths, 0, 0.04).widest_mm < 0.4);
  }
}

TEST_CASE("A wedge gets beads that narrow with it, and a disc between rings a bead in its middle") {
  geometry::Region wedge;
  outlines::add_polygon(wedge, {{0, 0}, {50, 0}, {50, 7}});
  const std::vector<std::int32_t> widths = gap_widths(paths_of(wedge, 0, {}));
  REQUIRE(widths.size() >= 3);
  for (const std::int32_t w : widths) CHECK((w >= 7000 && w <= 30000));
  for (double radius = 1.0; radius < 9; radius += 0.37) {
    INFO("radius " << radius);
    geometry::Region disc;
    outlines::add_circle(disc, 3, 4, radius, 40);
    CHECK(oracle::widest_spot(disc, -0.15, paths_of(disc, 0, {}), 0, 0.05).widest_mm <= 0.9);
  }
}

// A long wall whose half width varies, by less than the drawing tolerance of rings, about the depth of the
// second ring: that ring exists only in parts, and the drawn one differs from it.
geometry::Region doubtful_wall(std::uint64_t seed) {
  RandomStream random(seed, Purpose::kTest);
  const double mean = 2.85 + random.uniform(-0.012, 0.004), wave = random.uniform(0.002, 0.02),
               step = random.uniform(1.0, 6.0);
  std::vector<std::pair<double, double>> points;
  for (double x = 0; x < 60; x += step) points.push_back({x, -mean - wave * random.uniform(-1, 1)});
  for (double x = 60; x > 0; x -= step) points.push_back({x, mean + wave * random.uniform(-1, 1)});
  geometry::Region wall;
  outlines::add_polygon(wall, points);
  return wall;
}

TEST_CASE("Extrusion lines go on where the next ring only seems to run") {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    INFO("seed " << seed);
    const geometry::Region wall = doubtful_wall(seed);
    CHECK(oracle::widest_spot(wall, -0.15, paths_of(wall, 0, {}), 0, 0.1).widest_mm <= 1.5);
  }
}

// The sharpest turn of open lines, rad, at a corner or within `within_mm` of way.
double sharpest_turn_rad(const LayerPaths& paths, double within_mm) {
  double sharpest = 0;
  for (std::size_t i = 0; i < paths.info.size(); ++i) {
    if (paths.info[i].closed) continue;
    const auto line = paths.lines[i];
    for (std::size_t p = 1; p + 1 < line.size(); ++p) {
      double turn = 0, way = 0;
      for (std::size_t q = p; q + 1 < line.size() && way <= within_mm; ++q) {
        const geometry::Vec in = to_vec(line[q]) - to_vec(line[q - 1]),
                            out = to_vec(line[q + 1]) - to_vec(line[q]);
        turn += std::abs(std::atan2(cross(in, out), dot(in, out)));
        way += geometry::kMmPerUnit * length(out);
        sharpest = std::max(sharpest, turn);
      }
    }
  }
  return sharpest;
}

TEST_CASE(
    "Extrusion lines in gaps neither turn back nor zigzag: no more than a right angle within twice the "
    "tolerance") {
  for (const double tolerance : {0.05, 0.01, 0.0}) {
    PathOptions options;
    options.chord_tolerance_mm = tolerance;
    for (const std::uint8_t material : {0, 1}) {
      for (const outlines::Named& shape : outlines::all()) {
        INFO(shape.name << ", material " << int(material) << ", tolerance " << tolerance);
        CHECK(sharpest_turn_rad(paths_of(shape.region, material, options), 0.1) < 0.5 * outlines::kPi + 1e-3);
      }
      for (std::uint64_t seed = 1; seed <= 40; ++seed) {
        INFO("seed " << seed << ", material " << int(material) << ", tolerance " << tolerance);
        const geometry::Region region =
            seed % 2 ? outlines::random_star(seed, 10 + int(seed), 4, 22) : outlines::blob(seed);
        CHECK(sharpest_turn_rad(paths_of(region, material, options), 0.1) < 0.5 * outlines::kPi + 1e-3);
      }
    }
  }
}

TEST_CASE("Where rings cover everything there are no further beads") {
  geometry::Region box;
  outlines::add_box(box, 0, 0, 30, 30);
  CHECK(gap_widths(paths_of(box, 0, {})).empty());
  geometry::Region ring;
  outlines::add_circle(ring, 0, 0, 20, 200);
  outlines::add_circle(ring, 0, 0, 20 - 2 * (0.6 + 0.75 + 3.0), 200, true);
  CHECK(gap_widths(paths_of(ring, 0, {})).empty());
}

TEST_CASE("Extrusion lines in gaps stay within the area that is wanted but for the ends of tapers") {
  for (const outlines::Named& shape : outlines::all()) {
    INFO(shape.name);
    const LayerPaths paths = paths_of(shape.region, 0, {});
    for (std::size_t i = 0; i < paths.info.size(); ++i) {
      if (paths.info[i].closed) continue;
      CHECK(paths.info[i].width >= 7499);
      CHECK(paths.info[i].width <= 30001);
      for (const geometry::Point p : paths.lines[i]) CHECK(winding(shape.region, p) > 0);
    }
  }
}

}  // namespace
}  // namespace firn::slice
