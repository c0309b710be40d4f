#include <catch2/catch.hpp>

#include "core/geometry/clipper.h"
#include "core/geometry/intersection.h"
#include "core/slice/offset/offset_rings.h"
#include "tests/core/slice/offset_oracle.h"
#include "tests/core/slice/outlines.h"
#include "tests/support/long_cases.h"

namespace firn::slice {
namespace {

double area_of(const geometry::Rings& rings) {
  double sum = 0;
  for (const oracle::Segment& s : oracle::segments_of(rings)) sum += 0.5 * cross(s.a, s.b);
  return sum * geometry::kMmPerUnit * geometry::kMmPerUnit;
}

TEST_CASE(
    "Every ring lies within the chord tolerance of the exact offset of the original outline, both ways") {
  const double tolerance_mm = GENERATE(0.05, 0.01, 0.0);
  std::size_t turn = (tolerance_mm > 0.02) + 2 * (tolerance_mm == 0.01);
  for (const outlines::Named& shape : outlines::all()) {
    if (++turn % 3 != 0 && !test::full_cases()) continue;  // each shape with one tolerance
    const RingPlan plan;
    const RingLevels rings = offset_rings(shape.region, plan, tolerance_mm);
    CHECK(rings.from_clipper == 0);
    for (int level = 0; level < int(rings.levels.size()); ++level) {
      INFO(shape.name << ", tolerance " << tolerance_mm << " mm, level " << level);
      const double step = 200, d = plan.distance_mm(level) * geometry::kUnitsPerMm;
      const oracle::Hausdorff h =
          oracle::hausdorff(shape.region, rings.levels[std::size_t(level)], d, step, 3000);
      // The exact offset is sampled: the one next to a corner is up to a step from it.
      const double allowed = tolerance_mm * geometry::kUnitsPerMm + 12;
      CHECK(h.exact_to_ring <= allowed);
      CHECK(h.ring_to_exact <= std::hypot(allowed, step) + 1);
    }
  }
}

TEST_CASE("Rings go on until nothing is left") {
  for (const outlines::Named& shape : outlines::all()) {
    INFO(shape.name);
    const RingPlan plan;
    const RingLevels rings = offset_rings(shape.region, plan, 0.05);
    REQUIRE_FALSE(rings.levels.empty());
    CHECK(oracle::exact_offset(shape.region,
                               plan.distance_mm(int(rings.levels.size())) * geometry::kUnitsPerMm, 100)
              .empty());
  }
}

TEST_CASE("No ring crosses or touches itself or another of its level") {
  const double tolerance_mm = GENERATE(0.3, 0.05, 0.01, 0.0);
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    INFO("star " << seed);
    const geometry::Region star = outlines::random_star(seed, 12 + int(seed) * 3, 3, 30);
    const RingLevels rings =
        offset_rings(star, {.first_mm = 0.3, .boundary_width_mm = 0.7, .fill_width_mm = 0.9}, tolerance_mm);
    CHECK(rings.from_clipper == 0);
    for (const geometry::Rings& level : rings.levels)
      CHECK(intersection_of(level) == geometry::Intersection::kDisjoint);
  }
}

TEST_CASE("Rings enclose what Clipper's offsets of the original enclose") {
  for (const outlines::Named& shape : outlines::all()) {
    const RingPlan plan;
    const RingLevels rings = offset_rings(shape.region, plan, 0.0);
    for (int level = 0; level < int(rings.levels.size()); ++level) {
      INFO(shape.name << ", level " << level);
      const geometry::Rings clipper = clipper_offset(shape.region, plan.distance_mm(level), 0.001);
      CHECK(rings.levels[std::size_t(level)].size() == clipper.size());
      CHECK(area_of(rings.levels[std::size_t(level)]) == Approx(area_of(clipper)).epsilon(1e-3).margin(0.02));
    }
  }
}

TEST_CASE("The rings of a box are the boxes within it") {
  geometry::Region box;
  outlines::add_box(box, 0, 0, 40, 20);
  const RingPlan plan;
  const RingLevels rings = offset_rings(box, plan, 0.05);
  REQUIRE(rings.levels.size() == 4);  // 0.6, 2.85, 5.85, 8.85 < 10
  for (int level = 0; level < 4; ++level) {
    const double d = plan.distance_mm(level);
    REQUIRE(rings.levels[std::size_t(level)].size() == 1);
    CHECK(rings.levels[std::size_t(level)].points.size() == 4);
    CHECK(area_of(rings.levels[std::size_t(level)]) == Approx((40 - 2 * d) * (20 - 2 * d)).margin(0.01));
  }
}

TEST_CASE("Distances: boundaries a boundary width apart, then fill beside the innermost bead") {
  const RingPlan plan{.first_mm = 1.2, .boundaries = 2};
  CHECK(plan.distance_mm(0) == Approx(1.2));
  CHECK(plan.distance_mm(1) == Approx(2.7));
  CHECK(plan.distance_mm(2) == Approx(2.7 + 0.75 + 1.5));
  CHECK(plan.distance_mm(3) == Approx(2.7 + 0.75 + 1.5 + 3.0));
}

TEST_CASE("Outlines without room for a ring give none, and odd ones no trouble") {
  const RingPlan plan;
  CHECK(offset_rings({}, plan, 0.05).levels.empty());
  geometry::Region sliver;
  outlines::add_box(sliver, 0, 0, 100, 1.19);
  CHECK(offset_rings(sliver, plan, 0.05).levels.empty());
  geometry::Region island;
  outlines::add_circle(island, 5, 5, 0.59, 30);
  CHECK(offset_rings(island, plan, 0.05).levels.empty());
  geometry::Region grain;  // three units across
  const geometry::Point corners[] = {{0, 0}, {3, 0}, {0, 3}};
  grain.add(corners);
  CHECK(offset_rings(grain, plan, 0.05).levels.empty());
  geometry::Region flat;  // no area at all
  const geometry::Point line[] = {{0, 0}, {100000, 0}, {200000, 0}};
  flat.add(line);
  CHECK(offset_rings(flat, plan, 0.05).levels.empty());
  geometry::Region just;  // a ring of 0.02 mm width is still one
  outlines::add_box(just, 0, 0, 30, 1.22);
  CHECK(offset_rings(just, plan, 0.05).levels.size() == 1);
}

TEST_CASE("Rings do not depend on where an outline begins") {
  for (const outlines::Named& shape : outlines::all()) {
    INFO(shape.name);
    geometry::Region turned;
    for (std::size_t r = 0; r < shape.region.size(); ++r) {
      std::vector<geometry::Point> ring(shape.region[r].begin(), shape.region[r].end());
      std::rotate(ring.begin(), ring.begin() + std::ptrdiff_t(ring.size() / 3), ring.end());
      turned.add(ring);
    }
    const RingLevels a = offset_rings(shape.region, {}, 0.05), b = offset_rings(turned, {}, 0.05);
    REQUIRE(a.levels.size() == b.levels.size());
    for (std::size_t level = 0; level < a.levels.size(); ++level) {
      CHECK(a.levels[level].size() == b.levels[level].size());
      CHECK(area_of(a.levels[level]) == Approx(area_of(b.levels[level])).epsilon(2e-3).margin(0.05));
    }
  }
}

TEST_CASE("Growing reaches exactly as far as asked and closes what it reaches across") {
  for (const outlines::Named& shape : outlines::all()) {
    INFO(shape.name);
    const geometry::Region grown = grow(shape.region, 3.3, 0.01);
    CHECK(intersection_of(grown) == geometry::Intersection::kDisjoint);
    const std::vector<oracle::Segment> outline = oracle::segments_of(shape.region);
    for (const geometry::Vec p : oracle::along(grown, 3000))
      CHECK(std::abs(oracle::distance_to_all(p, outline) - 33000) < 120);
    CHECK(area_of(grown) == Approx(area_of(clipper_offset(shape.region, -3.3, 0.001))).epsilon(1e-3));
  }
  CHECK(grow({}, 3.3, 0.05).empty());
}

}  // namespace
}  // namespace firn::slice
