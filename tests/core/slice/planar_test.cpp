#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <polyclipping/clipper.hpp>

#include "core/geometry/groups.h"
#include "core/geometry/planar.h"
#include "core/grid/random.h"
#include "tests/core/slice/oracles.h"

using namespace firn;
using namespace firn::geometry;
using firn::test::crossing_by_all_pairs;

namespace {

geometry::Rings tangle(RandomStream& random, int rings, int points, std::uint32_t span) {
  geometry::Rings out;
  for (int r = 0; r < rings; ++r) {
    std::vector<geometry::Point> ring;
    for (int i = 0; i < points; ++i)
      ring.push_back({std::int32_t(random.below(span)), std::int32_t(random.below(span))});
    out.add(ring);
  }
  return out;
}

geometry::Rings one(std::initializer_list<geometry::Point> ring) {
  geometry::Rings out;
  out.add(std::vector<geometry::Point>(ring));
  return out;
}

geometry::Rings by_clipper(ClipperLib::ClipType type, const geometry::Rings& a, const geometry::Rings& b) {
  ClipperLib::Clipper clipper;
  for (const auto& [rings, role] : {std::pair(&a, ClipperLib::ptSubject), std::pair(&b, ClipperLib::ptClip)})
    for (std::size_t r = 0; r < rings->size(); ++r) {
      ClipperLib::Path path;
      for (const geometry::Point p : (*rings)[r]) path.push_back({p.x, p.y});
      clipper.AddPath(path, role, true);
    }
  ClipperLib::Paths paths;
  clipper.Execute(type, paths, ClipperLib::pftPositive, ClipperLib::pftPositive);
  geometry::Rings out;
  for (const ClipperLib::Path& path : paths) {
    std::vector<geometry::Point> ring;
    for (const ClipperLib::IntPoint& p : path) ring.push_back({std::int32_t(p.X), std::int32_t(p.Y)});
    if (ring.size() >= 3) out.add(ring);
  }
  return out;
}

// Points of a fine lattice, off the grid's lines by an odd fraction, each judged against the rings as they
// came.
std::size_t differing(const geometry::Rings& before, const geometry::Region& after, std::int32_t span, int n,
                      RandomStream& random) {
  std::size_t differ = 0;
  for (int k = 0; k < n; ++k) {
    const geometry::Point at{std::int32_t(random.below(std::uint32_t(span))),
                             std::int32_t(random.below(std::uint32_t(span)))};
    differ += (winding(before, at) > 0) != (winding(after, at) > 0);
  }
  return differ;
}

}  // namespace

TEST_CASE("Tangled rings become rings that cross nowhere round the points of positive winding number") {
  RandomStream random(11, Purpose::kTest);
  for (int round = 0; round < 60; ++round) {
    const std::uint32_t span = round % 3 == 0 ? 40 : round % 3 == 1 ? 5'000 : 900'000'000;
    const geometry::Rings rings = tangle(random, 1 + int(random.below(4)), 3 + int(random.below(25)), span);
    const geometry::Region region = region_of(rings);
    INFO("round " << round);
    REQUIRE(crossing_by_all_pairs(region) == "");
    REQUIRE(canonical(region) == region);
    REQUIRE(crossing_by_all_pairs(region_of(region)) == "");
    for (std::size_t r = 0; r < region.size(); ++r) REQUIRE(twice_area(region[r]) != 0);
    if (span > 4'000)
      REQUIRE(differing(rings, region, std::int32_t(span), 300, random) <= (span < 10'000 ? 3u : 0u));
  }
}

TEST_CASE("Winding numbers in a Region are 0 and 1 only") {
  RandomStream random(12, Purpose::kTest);
  for (int round = 0; round < 20; ++round) {
    const geometry::Region region = region_of(tangle(random, 3, 20, 100'000));
    for (int k = 0; k < 200; ++k) {
      const int w =
          winding(region, {std::int32_t(random.below(100'000)), std::int32_t(random.below(100'000))});
      REQUIRE((w == 0 || w == 1));
    }
  }
}

TEST_CASE("The order of rings and where they begin change nothing") {
  RandomStream random(13, Purpose::kTest);
  for (int round = 0; round < 20; ++round) {
    const geometry::Rings rings = tangle(random, 4, 12, 3'000);
    geometry::Rings other;
    for (std::size_t r = rings.size(); r-- > 0;) {
      std::vector<geometry::Point> ring(rings[r].begin(), rings[r].end());
      std::rotate(ring.begin(), ring.begin() + random.below(12), ring.end());
      other.add(ring);
    }
    REQUIRE(region_of(other) == region_of(rings));
  }
}

TEST_CASE("Unions and differences agree in area with Clipper, within the rounding of corners") {
  RandomStream random(14, Purpose::kTest);
  for (int round = 0; round < 25; ++round) {
    const geometry::Region a = region_of(tangle(random, 2, 12, 2'000'000)),
                           b = region_of(tangle(random, 2, 12, 2'000'000));
    CHECK(area_mm2(unite(a, b)) == Approx(area_mm2(by_clipper(ClipperLib::ctUnion, a, b))).margin(1e-4));
    CHECK(area_mm2(subtract(a, b)) ==
          Approx(area_mm2(by_clipper(ClipperLib::ctDifference, a, b))).margin(1e-4));
    CHECK(area_mm2(unite(a, b)) + area_mm2(common(a, b)) == Approx(area_mm2(a) + area_mm2(b)).margin(1e-4));
    CHECK(area_mm2(subtract(a, b)) + area_mm2(common(a, b)) == Approx(area_mm2(a)).margin(1e-4));
  }
}

TEST_CASE("Squares that share an edge become one, those that share a corner stay two") {
  geometry::Rings edge = one({{0, 0}, {10, 0}, {10, 10}, {0, 10}});
  edge.add(std::vector<geometry::Point>{{10, 0}, {20, 0}, {20, 10}, {10, 10}});
  CHECK(region_of(edge).size() == 1);
  geometry::Rings corner = one({{0, 0}, {10, 0}, {10, 10}, {0, 10}});
  corner.add(std::vector<geometry::Point>{{10, 10}, {20, 10}, {20, 20}, {10, 20}});
  const geometry::Region two = region_of(corner);
  REQUIRE(two.size() == 2);
  CHECK(two[0].size() == 4);
  CHECK(crossing_by_all_pairs(two) == "");
}

TEST_CASE("A hole that touches its outline in a point stays a ring of its own") {
  geometry::Rings rings = one({{0, 0}, {30, 0}, {30, 30}, {0, 30}});
  rings.add(std::vector<geometry::Point>{{15, 0}, {10, 10}, {20, 10}});  // clockwise, its tip on the outline
  const geometry::Region region = region_of(rings);
  REQUIRE(region.size() == 2);
  CHECK(twice_area(region[0]) + twice_area(region[1]) == 2 * (900 - 50));
}

TEST_CASE("Spikes, folds and rings without area vanish") {
  CHECK(region_of(one({{0, 0}, {10, 0}, {5, 0}})).empty());
  CHECK(region_of(one({{0, 0}, {10, 0}})).empty());
  CHECK(region_of(one({{0, 0}, {10, 0}, {10, 10}, {0, 10}, {0, 25}, {0, 10}})).points.size() == 4);
  CHECK(geometry::region_of({}).empty());
  CHECK(region_of(one({{0, 0}, {0, 10}, {10, 10}, {10, 0}})).empty());  // clockwise: winding number -1
}

TEST_CASE("first_contact finds what comparing all pairs finds") {
  RandomStream random(15, Purpose::kTest);
  int met = 0;
  for (int round = 0; round < 400; ++round) {
    // A star-shaped ring, now and then with one point moved.
    std::vector<geometry::Point> ring;
    const int n = 5 + int(random.below(40));
    for (int i = 0; i < n; ++i) {
      const double a = 2 * M_PI * i / n, r = random.uniform(500, 1000);
      ring.push_back({std::int32_t(r * std::cos(a)), std::int32_t(r * std::sin(a))});
    }
    if (random.below(2))
      ring[random.below(std::uint32_t(n))] = {std::int32_t(random.below(1000)),
                                              std::int32_t(random.below(1000))};
    geometry::Rings rings;
    rings.add(ring);
    const bool apart = !first_contact(rings), in_order = crossing_by_all_pairs(rings) == "";
    met += !apart;
    REQUIRE(apart == in_order);  // a single ring without a point twice: no corner may touch
  }
  CHECK(met > 50);
  geometry::Rings touching = one({{0, 0}, {10, 0}, {10, 10}, {0, 10}});
  touching.add(std::vector<geometry::Point>{{10, 5}, {20, 0}, {20, 10}});
  REQUIRE(first_contact(touching));
  CHECK(first_contact(touching)->at == geometry::Point{10, 5});
}

TEST_CASE("Each hole belongs to the smallest ring about it, in whatever order the rings come") {
  RandomStream random(8, Purpose::kTest);
  for (int round = 0; round < 40; ++round) {
    struct Box {
      std::int32_t x, y, half;
      std::size_t around;  // number of the box about it, if it is a hole
      bool hole;
    };
    std::vector<Box> boxes;
    for (int cell = 0, count = 1 + int(random.below(120)); cell < count; ++cell) {
      const std::size_t depth = 1 + random.below(6);  // islands in holes of islands
      for (std::size_t k = 0; k < depth; ++k)
        boxes.push_back(
            {cell % 11 * 1000, cell / 11 * 1000, std::int32_t(490 - 80 * k), boxes.size() - 1, k % 2 == 1});
    }
    std::vector<std::uint32_t> order(boxes.size());  // of the boxes in the region
    for (std::uint32_t i = 0; i < order.size(); ++i) {
      order[i] = i;
      std::swap(order[i], order[random.below(i + 1)]);
    }
    Region region;
    std::vector<std::uint32_t> ring_of(boxes.size());
    for (std::uint32_t r = 0; r < order.size(); ++r) {
      const Box& b = boxes[order[r]];
      std::vector<Point> ring = {{b.x - b.half, b.y - b.half},
                                 {b.x + b.half, b.y - b.half},
                                 {b.x + b.half, b.y + b.half},
                                 {b.x - b.half, b.y + b.half}};
      if (b.hole) std::reverse(ring.begin(), ring.end());
      region.add(ring);
      ring_of[order[r]] = r;
    }
    std::vector<std::vector<std::uint32_t>> expected;
    for (const std::uint32_t outer : order) {
      if (boxes[outer].hole) continue;
      expected.push_back({ring_of[outer]});
      for (const std::uint32_t hole : order)
        if (boxes[hole].hole && boxes[hole].around == outer) expected.back().push_back(ring_of[hole]);
    }
    REQUIRE(nested_groups(region) == expected);
  }
}
