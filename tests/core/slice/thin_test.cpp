#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>

#include "core/slice/thin.h"
#include "tests/core/slice/offset_oracle.h"
#include "tests/core/slice/oracles.h"

using namespace firn;
using namespace firn::slice;

namespace {

// Furthest place of one closed line from another, every unit of `step`.
double furthest(const std::vector<oracle::Segment>& from, const std::vector<oracle::Segment>& to, double step) {
  double worst = 0;
  for (const oracle::Segment& s : from) {
    const int n = std::max(1, int(std::ceil(length(s.b - s.a) / step)));
    for (int i = 0; i < n; ++i) worst = std::max(worst, oracle::distance_to_all(s.a + (double(i) / n) * (s.b - s.a), to));
  }
  return worst;
}

std::vector<oracle::Segment> closed(std::span<const Vec> line) {
  std::vector<oracle::Segment> list;
  for (std::size_t i = 0; i < line.size(); ++i) list.push_back({line[i], line[i + 1 < line.size() ? i + 1 : 0]});
  return list;
}

std::vector<Vec> circle(double radius, int n) {
  std::vector<Vec> line;
  for (int i = 0; i < n; ++i) line.push_back({radius * std::cos(2 * M_PI * i / n), radius * std::sin(2 * M_PI * i / n)});
  return line;
}

}  // namespace

TEST_CASE("A thinned ring lies within the tolerance of the ring, both ways, whatever its shape") {
  RandomStream random(31, Purpose::kTest);
  for (int trial = 0; trial < 60; ++trial) {
    const int n = 200 + 20 * (trial % 11), spikes = trial % 7;
    const double noise = trial % 3 == 0 ? 0 : std::pow(10, random.uniform(0, 3.5)), depth = random.uniform(0, 0.9);
    std::vector<Vec> line;
    for (int i = 0; i < n; ++i) {
      const double a = 2 * M_PI * i / n;
      const double r = 60'000 * (1 + depth * (spikes % 2 ? std::cos(spikes * a) : std::abs(std::remainder(spikes * a, 2.0)) - 0.5));
      line.push_back({r * std::cos(a) + random.uniform(-noise, noise), r * std::sin(a) + random.uniform(-noise, noise)});
    }
    for (const double tolerance : {10.0, 150.0, 350.0, 2'000.0}) {
      Rings rings;
      if (!thin_ring(line, tolerance, rings)) continue;
      const auto before = closed(line), after = oracle::segments_of(rings);
      INFO("trial " << trial << ", tolerance " << tolerance);
      CHECK(furthest(before, after, 100) <= tolerance + 1);
      CHECK(furthest(after, before, 100) <= tolerance + 1);
    }
  }
}

TEST_CASE("A circle takes as few edges as any closed line within the tolerance on both sides of it") {
  for (const double radius : {5'000.0, 100'000.0, 2'000'000.0})
    for (const double tolerance : {100.0, 350.0}) {
      Rings rings;
      REQUIRE(thin_ring(circle(radius, 20'000), tolerance, rings));
      // An edge from the outer to the outer circle that touches the inner one.
      const double fewest = M_PI / std::acos((radius - tolerance) / (radius + tolerance));
      CHECK(double(rings.points.size()) >= fewest - 1e-9);
      CHECK(double(rings.points.size()) <= 1.05 * fewest + 3);
    }
}

TEST_CASE("Corners between straight edges stay where they are") {
  std::vector<Vec> line;
  const Vec corners[] = {{0, 0}, {90'000, 0}, {90'000, 40'000}, {50'000, 40'000}, {50'000, 70'000}, {-20'000, 70'000}};
  for (int c = 0; c < 6; ++c)
    for (int i = 0; i < 20; ++i) line.push_back(corners[c] + (i / 20.0) * (corners[(c + 1) % 6] - corners[c]));
  Rings rings;
  REQUIRE(thin_ring(line, 350, rings));
  std::vector<Point> expected;
  for (const Vec c : corners) expected.push_back(to_point(c));
  CHECK(rings.points == expected);
}

TEST_CASE("What would lose its area keeps its points, what has none is left out") {
  Rings rings;
  CHECK(thin_ring(std::vector<Vec>{{0, 0}, {1'000, -20}, {2'000, 0}, {1'500, 10}, {1'000, 20}}, 350, rings));
  CHECK(rings.points.size() == 5);
  CHECK_FALSE(thin_ring(std::vector<Vec>{{0, 0}, {1'000, 0}, {2'000, 0}, {1'500, 0}, {1'000, 0}}, 350, rings));
  CHECK(rings.size() == 1);
}
