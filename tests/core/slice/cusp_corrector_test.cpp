// Rings from simplified outlines against the exact offset of the contours that they were simplified from.
#include <catch2/catch.hpp>

#include <cmath>

#include "core/geometry/planar.h"
#include "core/geometry/rings.h"
#include "core/slice/mesh/path_filter.h"
#include "core/slice/offset/offset_rings.h"
#include "core/slice/paths/path_options.h"
#include "tests/core/slice/offset_oracle.h"
#include "tests/core/slice/oracles.h"
#include "tests/core/slice/outlines.h"

namespace firn::slice {
namespace {

// A closed wavy line with sharp cusps: r(a) in mm between the points of a star, walls bent so that they take
// many points.
geometry::Rings star(int cusps, double inner_mm, double outer_mm, double bend, double wobble_mm,
                     RandomStream& random) {
  geometry::Rings rings;
  std::vector<geometry::Point> ring;
  const int n = 400 * cusps;
  const double phase = random.uniform(0, 6);
  for (int i = 0; i < n; ++i) {
    const double a = 2 * M_PI * i / n,
                 s = std::abs(std::remainder(cusps * a / (2 * M_PI), 1.0)) * 2;  // 0 at cusps, 1 between
    const double r = outer_mm + (inner_mm - outer_mm) * std::pow(s, bend) +
                     wobble_mm * std::sin(37 * a + phase) + random.uniform(-0.01, 0.01);
    ring.push_back(geometry::to_point({1e4 * r * std::cos(a), 1e4 * r * std::sin(a)}));
  }
  rings.add(ring);
  return region_of(rings);
}

geometry::Rings simplified(const geometry::Rings& contours, double mm) {
  geometry::Rings out;
  PathFilter filter(0, mm * geometry::kUnitsPerMm);
  for (std::size_t r = 0; r < contours.size(); ++r) filter.append(contours[r], out);
  return region_of(out);
}

}  // namespace

TEST_CASE(
    "Rings of simplified stars, gears and needles lie within 0.05 mm of the exact offset of their own "
    "contours, "
    "both ways") {
  RandomStream random(71, Purpose::kTest);
  const double filter_mm = kOutlineShare * 0.05, ring_mm = kRingShare * 0.05;
  for (int trial = 0; trial < 12; ++trial) {
    const geometry::Rings contours = star(3 + trial, random.uniform(6, 14), random.uniform(25, 60),
                                          0.4 + 0.15 * (trial % 6), 0.02 * (trial % 3), random);
    const geometry::Rings outline = simplified(contours, filter_mm);
    const RingPlan plan;
    const RingLevels rings = offset_rings(outline, plan, ring_mm, 0, {&contours, filter_mm, true});
    for (int level = 0; level < int(rings.levels.size()); ++level) {
      INFO("trial " << trial << ", level " << level);
      const double step = 250, d = plan.distance_mm(level) * geometry::kUnitsPerMm;
      const oracle::Hausdorff h =
          oracle::hausdorff(contours, rings.levels[std::size_t(level)], d, step, 6000);
      CHECK(h.exact_to_ring <= 500);
      CHECK(h.ring_to_exact <= std::hypot(500, 0.5 * step));
    }
  }
}

TEST_CASE("Without contours rings are those of the outline alone") {
  RandomStream random(72, Purpose::kTest);
  const geometry::Rings contours = star(5, 8, 30, 0.7, 0, random), outline = simplified(contours, 0.02), none;
  const RingLevels alone = offset_rings(outline, {}, 0.03),
                   asked = offset_rings(outline, {}, 0.03, 0, {&none, 0.02, true});
  CHECK(alone.levels == asked.levels);
}

// Two lobes joined by a strait whose walls are about as far apart as two sides of a ring.
geometry::Rings lobes(double half_mm, double wobble_mm, RandomStream& random) {
  return outlines::between_walls(25, 2000, random, [=](double x) {
    const double from_lobe = (std::abs(x) - 16) / 8;
    return half_mm + wobble_mm * std::sin(3 * x) + 8 * std::max(0.0, 1 - from_lobe * from_lobe);
  });
}

// Is every level within 0.05 mm of the exact offset, both ways?
bool exact(const geometry::Rings& contours, const RingLevels& rings, const RingPlan& plan) {
  bool all = true;
  for (std::size_t k = 0; k < rings.levels.size(); ++k) {
    const double step = 250;
    const oracle::Hausdorff h = oracle::hausdorff(
        contours, rings.levels[k], plan.distance_mm(int(k)) * geometry::kUnitsPerMm, step, 6000);
    all = all && h.exact_to_ring <= 500 && h.ring_to_exact <= std::hypot(500, 0.5 * step);
  }
  return all;
}

TEST_CASE(
    "A strait about as wide as two sides of a ring is open in the rings of its simplified outline where it "
    "is "
    "in its contours") {
  RandomStream random(74, Purpose::kTest);
  const double filter_mm = kOutlineShare * 0.05, ring_mm = kRingShare * 0.05;
  for (int trial = 0; trial < 30; ++trial) {
    const RingPlan plan;
    const int narrow = trial % 3;
    const geometry::Rings contours = outlines::hourglass(plan.distance_mm(narrow), random);
    const RingLevels rings =
        offset_rings(simplified(contours, filter_mm), plan, ring_mm, 0, {&contours, filter_mm, true});
    INFO("trial " << trial << ", level " << narrow);
    REQUIRE(int(rings.levels.size()) > narrow);
    const double step = 250, d = plan.distance_mm(narrow) * geometry::kUnitsPerMm;
    const oracle::Hausdorff h = oracle::hausdorff(contours, rings.levels[std::size_t(narrow)], d, step, 6000);
    CHECK(h.exact_to_ring <= 500);
    CHECK(h.ring_to_exact <= std::hypot(500, 0.5 * step));
  }
}

TEST_CASE("Areas do not change each other's rings, whichever of them are made again") {
  RandomStream random(73, Purpose::kTest);
  const double filter_mm = kOutlineShare * 0.05, ring_mm = kRingShare * 0.05;
  std::vector<geometry::Rings> shapes;
  int again = 0;
  for (int i = 0; i < 8; ++i) {
    geometry::Rings one = i % 2 ? lobes(RingPlan().distance_mm(1), 0.003 * i, random)
                                : star(3 + 2 * i, random.uniform(6, 14), random.uniform(25, 60),
                                       0.4 + 0.15 * (i % 6), 0, random);
    for (geometry::Point& p : one.points) p.x += 1'500'000 * i;
    shapes.push_back(std::move(one));
  }
  geometry::Rings contours, outlines;
  std::vector<geometry::Rings> alone;
  for (const geometry::Rings& one : shapes) {
    const geometry::Rings outline = simplified(one, filter_mm);
    contours.add(one[0]);
    outlines.add(outline[0]);
    const RingLevels rings = offset_rings(outline, {}, ring_mm, 0.75, {&one, filter_mm, true});
    again += rings.levels != offset_rings(outline, {}, ring_mm, 0.75, {&one, filter_mm, false}).levels;
    INFO("shape " << shapes.size());
    CHECK(exact(one, rings, {}));
    alone.resize(std::max(alone.size(), rings.levels.size()));
    for (std::size_t k = 0; k < rings.levels.size(); ++k)
      for (std::size_t r = 0; r < rings.levels[k].size(); ++r) alone[k].add(rings.levels[k][r]);
  }
  CHECK(again > 0);
  CHECK(again < 8);
  const RingLevels together = offset_rings(outlines, {}, ring_mm, 0.75, {&contours, filter_mm, true});
  REQUIRE(together.levels.size() == alone.size());
  REQUIRE(together.gaps.size() == alone.size() + 1);
  for (std::size_t k = 0; k < alone.size(); ++k) CHECK(canonical(together.levels[k]) == canonical(alone[k]));
}

}  // namespace firn::slice
