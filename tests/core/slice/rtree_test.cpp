// The R-tree against brute force over all boxes.
#include <catch2/catch.hpp>

#include <algorithm>
#include <utility>
#include <vector>

#include "core/geometry/rtree.h"
#include "core/grid/random.h"

using namespace firn;
using namespace firn::geometry;
using Box = geometry::BoxOf<std::int32_t>;

namespace {

Box random_box(RandomStream& random, std::int32_t room, std::int32_t size) {
  const auto number = [&](std::int32_t n) { return std::int32_t(random.uniform() * n) - n / 2; };
  const std::int32_t x = number(room), y = number(room);
  return {x, y, x + std::abs(number(size)), y + std::abs(number(size))};
}

std::vector<std::size_t> all_that_meet(const std::vector<Box>& boxes, const Box& asked) {
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < boxes.size(); ++i)
    if (boxes[i].meets(asked)) found.push_back(i);
  return found;
}

void require_same(const geometry::StaticRTree& search, const std::vector<Box>& boxes, RandomStream& random,
                  std::int32_t room) {
  for (int n = 0; n < 50; ++n) {
    const Box asked = random_box(random, room, n % 2 ? room / 8 : room / 2);
    const std::vector<std::size_t> expected = all_that_meet(boxes, asked);
    std::vector<std::size_t> found;
    search.touching(asked, [&](std::size_t i) { found.push_back(i); });
    REQUIRE(found == expected);
    found.clear();
    search.eights_touching(asked, [&](std::size_t first, unsigned which) {
      for (std::size_t k = 0; k < 8; ++k)
        if (which >> k & 1) found.push_back(first + k);
    });
    REQUIRE(found == expected);
    std::size_t asked_for = 0;
    const bool any =
        search.any_touching(asked, [&](std::size_t i) { return ++asked_for == 2 && i == expected[1]; });
    REQUIRE(any == (expected.size() > 1));
    REQUIRE(asked_for == std::min<std::size_t>(expected.size(), 2));
  }
}

}  // namespace

TEST_CASE(
    "A search among boxes finds all that meet, in ascending order, and stops when told, whatever was in it "
    "before") {
  geometry::StaticRTree search;  // kept: grows and shrinks
  RandomStream random(1, Purpose::kTest);
  for (const std::size_t count : {0, 1, 7, 8, 9, 64, 65, 700, 3, 520, 0, 17}) {
    for (const std::int32_t room : {20, 2'000'000'000}) {
      std::vector<Box> boxes(count);
      for (Box& b : boxes) b = random_box(random, room / 2, room / 10);
      search.resize(count);
      for (std::size_t i = 0; i < count; ++i) search.set(i, boxes[i]);
      search.build();
      require_same(search, boxes, random, room / 2);
    }
  }
}

TEST_CASE("All pairs of boxes that meet are found once, the smaller number first, at any size of the tree") {
  geometry::StaticRTree search;
  RandomStream random(3, Purpose::kTest);
  for (const std::size_t count : {0, 1, 2, 7, 8, 9, 64, 65, 600, 3}) {
    for (const std::int32_t room : {20, 2'000'000'000}) {
      std::vector<Box> boxes(count);
      for (Box& b : boxes) b = random_box(random, room / 2, room / 10);
      search.resize(count);
      for (std::size_t i = 0; i < count; ++i) search.set(i, boxes[i]);
      search.build();
      std::vector<std::pair<std::size_t, std::size_t>> expected, found;
      for (std::size_t i = 0; i < count; ++i)
        for (std::size_t j = i + 1; j < count; ++j)
          if (boxes[i].meets(boxes[j])) expected.push_back({i, j});
      search.pairs([&](std::size_t i, std::size_t j) { found.push_back({i, j}); });
      std::sort(found.begin(), found.end());
      REQUIRE(found == expected);
    }
  }
}

TEST_CASE("A search among the edges of rings has the box of each, from its point to the next in its ring") {
  geometry::StaticRTree search;
  RandomStream random(2, Purpose::kTest);
  for (int n = 0; n < 60; ++n) {
    geometry::Rings rings;
    std::vector<Box> boxes;
    for (int r = 0, count = n % 7; r < count; ++r) {
      std::vector<geometry::Point> ring(1 + random.bits() % 23);
      for (geometry::Point& p : ring)
        p = {std::int32_t(random.bits() % 1000), std::int32_t(random.bits() % 1000)};
      rings.add(ring);
      for (std::size_t i = 0; i < ring.size(); ++i) {
        const geometry::Point to = ring[(i + 1) % ring.size()];
        boxes.emplace_back().add(ring[i].x, ring[i].y);
        boxes.back().add(to.x, to.y);
      }
    }
    search.set_rings(rings);
    search.build();
    require_same(search, boxes, random, 2000);
  }
}
