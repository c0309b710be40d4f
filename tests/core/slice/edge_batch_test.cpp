// Edges compared two at a time against each of them alone.
#include <catch2/catch.hpp>

#include <limits>
#include <vector>

#include "core/grid/random.h"
#include "core/slice/offset/edge_batch.h"

using namespace firn;
using namespace firn::slice;

TEST_CASE(
    "The way from a wall is that from the nearest of its edges that run along it, whatever was known "
    "before") {
  RandomStream random(1, Purpose::kTest);
  EdgeBatch edges;  // kept: grows and shrinks
  int none = 0;
  for (int n = 0; n < 3000; ++n) {
    std::vector<geometry::Point> points(3 + random.bits() % 40);
    std::vector<std::uint32_t> next(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      points[i] = {std::int32_t(random.bits() % 2000) - 1000, std::int32_t(random.bits() % 2000) - 1000};
      next[i] = std::uint32_t((i + 1) % points.size());
    }
    const double turn = random.uniform(0, 6.3), other_turn = random.uniform(0, 6.3);
    const geometry::Vec along{std::cos(turn), std::sin(turn)},
        other{std::cos(other_turn), std::sin(other_turn)};
    const geometry::Vec p{random.uniform(-3000, 3000), random.uniform(-3000, 3000)};
    double nearest = std::numeric_limits<double>::infinity();
    edges.clear();
    for (std::size_t first = 0; first < points.size(); first += 8) {
      unsigned which = unsigned(random.bits() % 256);
      if (points.size() - first < 8) which &= (1u << (points.size() - first)) - 1;
      if (which) edges.add(points, next.data(), first, which, along, other);
      for (std::size_t k = 0; k < 8; ++k) {
        if (!(which >> k & 1)) continue;
        const geometry::Vec from = to_vec(points[first + k]), to = to_vec(points[next[first + k]]);
        if (dot(to - from, along) > 0 && dot(to - from, along) > dot(to - from, other))
          nearest = std::min(nearest, square_distance(p, from, to));
      }
    }
    REQUIRE(edges.empty() == (nearest == std::numeric_limits<double>::infinity()));
    none += edges.empty();
    if (!edges.empty()) REQUIRE(length(edges.way_to(p)) == Approx(std::sqrt(nearest)).margin(1e-6));
  }
  CHECK(none > 100);
  CHECK(none < 1500);
}
