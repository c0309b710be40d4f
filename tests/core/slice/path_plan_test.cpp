#include <catch2/catch.hpp>

#include <set>

#include "core/geometry/planar.h"
#include "core/slice/coverage/coverage.h"
#include "core/slice/offset/offset_rings.h"
#include "core/slice/paths/fill_lines.h"
#include "core/slice/paths/hook.h"
#include "core/slice/paths/order.h"
#include "core/slice/paths/path_plan.h"
#include "core/slice/support/scaffold.h"
#include "tests/core/slice/offset_oracle.h"
#include "tests/core/slice/outlines.h"

namespace firn::slice {
namespace {

LayerRegions layer_of(const geometry::Region& part, std::int32_t layer = 1) {
  return {layer, layer * 2500, 2500, {part}};
}

// Centre lines as a set that forgets order, direction and where closed ones begin.
std::multiset<std::vector<geometry::Point>> shapes_of(const LayerPaths& paths) {
  std::multiset<std::vector<geometry::Point>> shapes;
  for (std::size_t i = 0; i < paths.info.size(); ++i) {
    std::vector<geometry::Point> line(paths.lines[i].begin(), paths.lines[i].end());
    if (paths.info[i].closed)
      std::rotate(line.begin(), std::min_element(line.begin(), line.end()), line.end());
    else if (line.back() < line.front())
      std::reverse(line.begin(), line.end());
    shapes.insert(line);
  }
  return shapes;
}

TEST_CASE(
    "A layer's paths: boundary of 1.5 mm at the material's own offset, then fill of 3 mm [Barnett, 3.7]") {
  geometry::Region box;
  outlines::add_box(box, 0, 0, 30, 30);
  LayerRegions regions = layer_of(box);
  geometry::Region scaffold;
  outlines::add_box(scaffold, 40, 0, 70, 30);
  regions.by_material.push_back(scaffold);
  const LayerPaths paths = plan_layer(regions, {});
  REQUIRE(paths.info.size() ==
          12);  // 0.6, 2.85 ... 14.85 and 1.2, 3.45 ... 12.45, which leaves 2.1 mm in the middle
  CHECK_FALSE(paths.info[11].closed);
  CHECK(std::abs(paths.info[11].width - 21000) < 30);
  const double first[] = {0.6, 1.2};
  for (std::size_t i = 0; i < 11; ++i) {
    INFO("path " << i);
    const std::size_t m = i < 6 ? 0 : 1;
    const bool boundary = i == 0 || i == 6;
    CHECK(paths.info[i].material == m);
    CHECK(paths.info[i].closed);
    CHECK(paths.info[i].kind == (boundary ? PathKind::kBoundary : PathKind::kFill));
    CHECK(paths.info[i].width == (boundary ? 15000 : 30000));
    if (boundary) {
      const geometry::Region& outline = regions.by_material[m];
      for (const geometry::Point p : paths.lines[i])
        CHECK(oracle::distance_to_all(to_vec(p), oracle::segments_of(outline)) ==
              Approx(first[m] * geometry::kUnitsPerMm).margin(2));
    }
  }
  const std::vector<MaterialUse> use = material_use(paths);
  REQUIRE(use.size() == 2);
  double length = 4 * (30 - 1.2);
  double volume = length * 1.5 * 0.25;
  for (double d = 2.85; d < 15; d += 3) {
    length += 4 * (30 - 2 * d);
    volume += 4 * (30 - 2 * d) * 3.0 * 0.25;
  }
  CHECK(use[0].length_mm == Approx(length).epsilon(1e-4));
  CHECK(use[0].volume_mm3 == Approx(volume).epsilon(1e-4));
  REQUIRE(paths.lines.size() == 12);
  const firn::Path first_path = to_path(paths, 0);
  CHECK(first_path.z_mm == Approx(0.25));
  CHECK(first_path.width_mm == Approx(1.5));
  CHECK(first_path.points.size() == paths.lines[0].size());
}

TEST_CASE("Areas of what is wanted, swept, left and overlapped agree with each other") {
  for (const FillPattern pattern : {FillPattern::kConcentric, FillPattern::kLines, FillPattern::kZigzag}) {
    for (const outlines::Named& shape : outlines::all()) {
      INFO(shape.name << ", pattern " << int(pattern));
      PathOptions options;
      options.part.pattern = pattern;
      const LayerRegions regions = layer_of(shape.region);
      const std::vector<Coverage> covered = coverage(regions, plan_layer(regions, options), options, 0.1);
      REQUIRE(covered.size() == 1);
      const Coverage& c = covered[0];
      CHECK(c.wanted_mm2 + c.beyond_mm2 == Approx(c.swept_mm2 + c.gap_mm2).epsilon(1e-6));
      CHECK(c.widest_gap_mm <= 1.5 + 0.2);
      if (pattern == FillPattern::kConcentric) CHECK(c.beyond_mm2 < 0.03 * c.wanted_mm2);
    }
  }
}

TEST_CASE("Coverage of one square path is what geometry says") {
  geometry::Region box;
  outlines::add_box(box, 0, 0, 20, 20);
  PathOptions options;
  options.part.pattern = FillPattern::kNone;
  options.part.first_offset_mm = 0.75;
  const LayerRegions regions = layer_of(box);
  const Coverage c = coverage(regions, plan_layer(regions, options), options, 0.02)[0];
  const double corners = (4 - outlines::kPi) * 0.75 * 0.75;  // a round bead misses the corners
  CHECK(c.wanted_mm2 == Approx(400).epsilon(1e-3));
  CHECK(c.swept_mm2 == Approx(400 - 17 * 17 - corners).epsilon(2e-3));
  CHECK(c.gap_mm2 == Approx(17 * 17 + corners).epsilon(2e-3));
  CHECK(c.widest_gap_mm == Approx(17).epsilon(0.01));
  CHECK(c.overlap_mm2 == Approx(0).margin(0.05));
  CHECK(c.beyond_mm2 == Approx(0).margin(0.05));
}

TEST_CASE(
    "Parallel lines: all stretches inside, their length times the spacing is the area, at any angle [3.5]") {
  for (const double angle : {0.0, 0.4, 1.5707963267948966, 2.2}) {
    for (const outlines::Named& shape : outlines::all()) {
      INFO(shape.name << ", angle " << angle);
      const double spacing = 0.4;
      const geometry::Rings lines = fill_lines(shape.region, spacing, angle);
      double length_mm = 0;
      for (std::size_t i = 0; i < lines.size(); ++i) {
        REQUIRE(lines[i].size() == 2);
        const geometry::Vec a = to_vec(lines[i][0]), b = to_vec(lines[i][1]), way = b - a;
        length_mm += length(way) * geometry::kMmPerUnit;
        if (length(way) > 100) {
          CHECK(std::abs(cross(way, direction_at(angle))) < 2.5);
          const geometry::Vec middle = 0.5 * (a + b);  // a line along a wall is on the outline
          CHECK((winding(shape.region, geometry::to_point(middle)) > 0 ||
                 oracle::distance_to_all(middle, oracle::segments_of(shape.region)) < 2));
        }
      }
      CHECK(length_mm * spacing == Approx(area_mm2(shape.region)).epsilon(0.02));
    }
  }
}

TEST_CASE("A zigzag runs along the same lines and links them along the outline only") {
  for (const outlines::Named& shape : outlines::all()) {
    INFO(shape.name);
    const double spacing = 3.0, angle = 0.3;
    const geometry::Rings lines = fill_lines(shape.region, spacing, angle),
                          linked = fill_zigzag(shape.region, spacing, angle);
    CHECK(linked.size() <= lines.size());
    std::multiset<std::pair<geometry::Point, geometry::Point>> stretches, found;
    for (std::size_t i = 0; i < lines.size(); ++i) stretches.insert(std::minmax(lines[i][0], lines[i][1]));
    const std::vector<oracle::Segment> outline = oracle::segments_of(shape.region);
    for (std::size_t i = 0; i < linked.size(); ++i) {
      for (std::size_t p = 1; p < linked[i].size(); ++p) {
        const geometry::Point a = linked[i][p - 1], b = linked[i][p];
        const std::pair<geometry::Point, geometry::Point> key = std::minmax(a, b);
        if (stretches.count(key))
          found.insert(key);
        else
          CHECK(oracle::distance_to_all(0.5 * (to_vec(a) + to_vec(b)), outline) < 2);
      }
    }
    CHECK(found == stretches);
  }
  geometry::Region box;  // one zigzag fills a box
  outlines::add_box(box, 0.1, 0.1, 40, 31);
  CHECK(fill_zigzag(box, 3.0, 0.0).size() == 1);
}

TEST_CASE(
    "Layers of the same regions are planned once, as often as their lines turn or their hooks change, and as "
    "if alone") {
  const geometry::Region part = outlines::gear(), other = outlines::comb();
  geometry::Region around;
  outlines::add_box(around, -60, -60, 60, 60);
  PathOptions zigzag, hooks, random;
  zigzag.part.pattern = FillPattern::kZigzag;
  hooks.hook.on = true;
  hooks.hook.two_from_layer = 3;
  hooks.hook.last_layer = 6;
  random.seam = SeamPlacement::kRandom;
  const std::pair<PathOptions, std::uint64_t> cases[] = {
      {PathOptions{}, 3}, {zigzag, 10}, {hooks, 5}, {random, 10}};
  for (const auto& [options, planned] : cases) {
    PathWork work;
    for (std::int32_t n = 1; n <= 10; ++n) {
      LayerRegions regions = layer_of(n == 8 ? other : part, n);  // before and behind it all are alike
      regions.by_material.push_back(subtract(around, regions.by_material[0]));
      CHECK(plan_layer(regions, options, work) == plan_layer(regions, options));
    }
    CHECK(work.planned == planned);
  }
}

TEST_CASE("Lines turn from layer to layer") {
  geometry::Region box;
  outlines::add_box(box, 0, 0, 40, 20);
  PathOptions options;
  options.part.pattern = FillPattern::kLines;
  for (const int layer : {1, 2}) {
    const LayerPaths paths = plan_layer(layer_of(box, layer), options);
    const auto line = paths.lines[paths.info.size() - 1];
    CHECK((layer == 1 ? line[0].y == line[1].y : line[0].x == line[1].x));
  }
}

TEST_CASE("Order and seams change neither paths nor their number, and 2-opt never lengthens the way") {
  for (const FillPattern pattern : {FillPattern::kConcentric, FillPattern::kLines}) {
    for (const outlines::Named& shape : outlines::all()) {
      INFO(shape.name);
      PathOptions options;
      options.part.pattern = pattern;
      options.two_opt_passes = 0;
      const LayerPaths greedy = plan_layer(layer_of(shape.region), options);
      for (const SeamPlacement seam :
           {SeamPlacement::kNearest, SeamPlacement::kAligned, SeamPlacement::kRandom}) {
        options.seam = seam;
        options.two_opt_passes = 0;
        const LayerPaths before = plan_layer(layer_of(shape.region), options);
        options.two_opt_passes = 4;
        const LayerPaths after = plan_layer(layer_of(shape.region), options);
        CHECK(shapes_of(before) == shapes_of(greedy));
        CHECK(shapes_of(after) == shapes_of(greedy));
        if (before.info.size() == after.info.size() && pattern == FillPattern::kLines) {
          // The way counts from where the nozzle waits.
          const auto way = [](const LayerPaths& p) {
            return p.info.empty() ? 0.0
                                  : transit_mm(p) + length(to_vec(p.lines[0][0])) * geometry::kMmPerUnit;
          };
          CHECK(way(after) <= way(before) + 2e-3 * double(after.info.size()) + 40);
        }
      }
    }
  }
  geometry::Rings lines;  // both ends of 30 lines in a row, offered in a wild order
  for (int i = 0; i < 30; ++i) {
    const geometry::Point line[] = {outlines::at_mm(10 * ((i * 7) % 30), 0),
                                    outlines::at_mm(10 * ((i * 7) % 30), 5)};
    lines.add(line);
  }
  PathOptions options;
  LayerPaths paths;
  geometry::Point at{};
  append_in_order(lines, {PathKind::kFill, 0, false, 30000}, options, at, paths);
  CHECK(transit_mm(paths) == Approx(290));
}

TEST_CASE(
    "Seams: nearest shortens the way, aligned stands at the front of every ring, random follows its seed") {
  const geometry::Region blob = outlines::blob(3);
  PathOptions options;
  const LayerPaths nearest = plan_layer(layer_of(blob), options);
  options.seam = SeamPlacement::kAligned;
  const LayerPaths aligned = plan_layer(layer_of(blob), options);
  for (std::size_t i = 0; i < aligned.info.size(); ++i)
    for (const geometry::Point p : aligned.lines[i])
      if (aligned.info[i].closed) CHECK(p.y >= aligned.lines[i][0].y);
  options.seam = SeamPlacement::kRandom;
  const LayerPaths random = plan_layer(layer_of(blob), options);
  CHECK(plan_layer(layer_of(blob), options) == random);
  CHECK(transit_mm(nearest) < transit_mm(aligned));
  CHECK(transit_mm(nearest) < transit_mm(random));
  options.seed = 2;
  CHECK_FALSE(plan_layer(layer_of(blob), options) == random);
}

TEST_CASE(
    "The hook wall: the outermost scaffold path of layers 1 to 10 is ice, the two outermost of 11 to 20 "
    "[3.7]") {
  geometry::Region part;
  outlines::add_circle(part, 0, 0, 12, 90);
  const std::vector<geometry::Region> parts(30, part);
  const std::vector<geometry::Region> scaffold = scaffold_regions(parts, 2500, {}, 0.05);
  PathOptions options;
  options.hook.on = true;
  const int expected[] = {1, 1, 2, 2, 0};
  const int layers[] = {1, 10, 11, 20, 21};
  for (int i = 0; i < 5; ++i) {
    INFO("layer " << layers[i]);
    CHECK(hooks_in(layers[i], options.hook) == expected[i]);
    LayerRegions regions = layer_of(part, layers[i]);
    regions.by_material.push_back(scaffold[std::size_t(layers[i] - 1)]);
    const LayerPaths paths = plan_layer(regions, options);
    int hooks = 0;
    double furthest_scaffold = 0, nearest_hook = 1e9;
    for (std::size_t p = 0; p < paths.info.size(); ++p) {
      double low = 1e9, high = 0;
      for (const geometry::Point q : paths.lines[p]) {
        low = std::min(low, length(to_vec(q)));
        high = std::max(high, length(to_vec(q)));
      }
      if (paths.info[p].kind == PathKind::kHook) {
        ++hooks;
        CHECK(paths.info[p].material == kPartMaterial);
        nearest_hook = std::min(nearest_hook, low - 0.5 * paths.info[p].width);
      } else if (paths.info[p].material == kScaffoldMaterial) {
        furthest_scaffold = std::max(furthest_scaffold, high);
      }
    }
    CHECK(hooks == expected[i]);
    if (!hooks) continue;
    CHECK(nearest_hook * geometry::kMmPerUnit >=
          12 + options.hook.clearance_mm - 0.06);     // ice and hook do not merge
    CHECK(nearest_hook > furthest_scaffold - 30000);  // and it runs round the scaffold
  }
}

TEST_CASE("Hooks run round the part even where the scaffold is wide on one side and narrow on the other") {
  geometry::Region part, above;
  outlines::add_box(part, 0, 0, 30, 20);
  outlines::add_box(above, -25, 5, 10, 15);  // an arm above
  const std::vector<geometry::Region> parts{part, above};
  const std::vector<geometry::Region> scaffold = scaffold_regions(parts, 2500, {}, 0.05);
  PathOptions options;
  options.hook.on = true;
  LayerRegions regions = layer_of(part, 15);
  regions.by_material.push_back(scaffold[0]);
  const LayerPaths paths = plan_layer(regions, options);
  int hooks = 0;
  for (std::size_t i = 0; i < paths.info.size(); ++i) {
    if (paths.info[i].kind != PathKind::kHook) continue;
    ++hooks;
    geometry::Region ring;
    ring.add(paths.lines[i]);
    for (const geometry::Point corner : part.points) CHECK(winding(ring, corner) == 1);
  }
  CHECK(hooks == 2);
}

TEST_CASE("Hooks keep their clearance however wide it is, round islands and nooks alike") {
  for (const double clearance_mm : {0.0, 1.5, 9.0, 21.0}) {
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
      INFO("clearance " << clearance_mm << ", seed " << seed);
      geometry::Region part = outlines::random_star(seed, 14, 4, 18);
      outlines::add_circle(part, 45 + double(seed), 3, 4, 20);
      part = canonical(part);
      PathOptions options;
      options.hook.on = true;
      options.hook.clearance_mm = clearance_mm;
      LayerRegions regions = layer_of(part, 12);
      regions.by_material.push_back(scaffold_regions(std::vector<geometry::Region>{part}, 2500, {}, 0.05)[0]);
      const LayerPaths paths = plan_layer(regions, options);
      const std::vector<oracle::Segment> outline = oracle::segments_of(part);
      int hooks = 0;
      for (std::size_t i = 0; i < paths.info.size(); ++i) {
        if (paths.info[i].kind != PathKind::kHook) continue;
        ++hooks;
        for (const geometry::Point p : paths.lines[i])
          CHECK(oracle::distance_to_all(to_vec(p), outline) >=
                0.5 * paths.info[i].width + clearance_mm * geometry::kUnitsPerMm - 1100);
      }
      CHECK(hooks >= 2);
    }
  }
}

TEST_CASE("The hook wall fills the scaffold's area where it stands, and none of the part's") {
  geometry::Region part, above;
  outlines::add_circle(part, 0, 0, 8, 60);
  outlines::add_circle(above, 0, 0, 22, 120);
  LayerRegions regions = layer_of(part, 5);
  regions.by_material.push_back(
      scaffold_regions(std::vector<geometry::Region>{part, above}, 2500, {}, 0.05)[0]);
  PathOptions options;
  const auto without = coverage(regions, plan_layer(regions, options), options, 0.1);
  options.hook.on = true;
  const auto with = coverage(regions, plan_layer(regions, options), options, 0.1);
  CHECK(with[1].gap_mm2 <= without[1].gap_mm2 + 0.03 * without[1].wanted_mm2);
  CHECK(with[0].swept_mm2 == Approx(without[0].swept_mm2).epsilon(1e-6));
}

TEST_CASE("Measurement paths: lines of their own spacing inside one material, seen from the laser") {
  geometry::Region box;
  outlines::add_box(box, 0, 0, 30, 20);
  PathOptions options;
  options.measure.on = true;
  options.measure.spacing_mm = 4;
  options.measure.laser_x_mm = -30;
  options.measure.laser_y_mm = 19;  // [Table 3-1]
  const LayerPaths paths = plan_layer(layer_of(box), options);
  int lines = 0;
  for (std::size_t i = 0; i < paths.info.size(); ++i) {
    if (paths.info[i].kind != PathKind::kMeasurement) continue;
    ++lines;
    CHECK(paths.info[i].width == 0);
    for (const geometry::Point p : paths.lines[i]) {
      const geometry::Vec spot = to_vec(p) + geometry::Vec{-300000, 190000};
      CHECK((spot.x > 5990 && spot.x < 294010 && spot.y > 5990 && spot.y < 194010));
    }
  }
  CHECK(lines == 4);  // y = 4, 8, 12, 16
  CHECK(material_use(paths).size() == 1);
}

TEST_CASE("Empty layers, slivers and grains of sand give no paths and no harm") {
  CHECK(plan_layer({1, 2500, 2500, {}}, {}).info.empty());
  CHECK(plan_layer(layer_of({}), {}).info.empty());
  for (const FillPattern pattern :
       {FillPattern::kConcentric, FillPattern::kLines, FillPattern::kZigzag, FillPattern::kNone}) {
    PathOptions options;
    options.part.pattern = pattern;
    options.measure.on = true;
    options.hook.on = true;
    geometry::Region sliver, sand;
    outlines::add_box(sliver, 0, 0, 50, 1.0);
    outlines::add_circle(sand, 0, 0, 0.01, 7);
    CHECK(plan_layer(layer_of(sand), options).info.empty());
    // Too narrow for its first ring: one line along the middle, as wide as the sliver and its allowed spread.
    int beads = 0;
    for (const PathInfo& info : plan_layer(layer_of(sliver), options).info) {
      if (info.kind == PathKind::kMeasurement) continue;
      ++beads;
      CHECK((info.kind == PathKind::kBoundary && !info.closed && std::abs(info.width - 13000) < 20));
    }
    CHECK(beads == 1);
    options.part.gap_mm = 0;
    for (const PathInfo& info : plan_layer(layer_of(sliver), options).info)
      CHECK(info.kind == PathKind::kMeasurement);
    CHECK(coverage(layer_of(sand), {}, options).size() == 1);
    CHECK(coverage(layer_of({}), {}, options)[0].wanted_mm2 == 0);
  }
}

}  // namespace
}  // namespace firn::slice
