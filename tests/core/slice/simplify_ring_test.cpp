#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/geometry/minimum_link.h"
#include "core/geometry/simplify_ring.h"
#include "tests/core/slice/offset_oracle.h"
#include "tests/core/slice/oracles.h"

using namespace firn;
using namespace firn::geometry;

namespace {

// Maximum distance of a point of one closed line from another, at steps of `step`.
double furthest(const std::vector<oracle::Segment>& from, const std::vector<oracle::Segment>& to,
                double step) {
  double worst = 0;
  for (const oracle::Segment& s : from) {
    const int n = std::max(1, int(std::ceil(length(s.b - s.a) / step)));
    for (int i = 0; i < n; ++i)
      worst = std::max(worst, oracle::distance_to_all(s.a + (double(i) / n) * (s.b - s.a), to));
  }
  return worst;
}

std::vector<oracle::Segment> closed(std::span<const geometry::Vec> line) {
  std::vector<oracle::Segment> list;
  for (std::size_t i = 0; i < line.size(); ++i)
    list.push_back({line[i], line[i + 1 < line.size() ? i + 1 : 0]});
  return list;
}

constexpr bool kBoth[] = {false, true};

// @param few by MinimumLinkSimplifier, else by simplify_ring()
bool simplified(bool few, const std::vector<geometry::Vec>& line, double tolerance, geometry::Rings& rings) {
  return few ? geometry::MinimumLinkSimplifier()(line, tolerance, rings)
             : simplify_ring(line, tolerance, rings);
}

std::vector<geometry::Vec> circle(double radius, int n) {
  std::vector<geometry::Vec> line;
  for (int i = 0; i < n; ++i)
    line.push_back({radius * std::cos(2 * M_PI * i / n), radius * std::sin(2 * M_PI * i / n)});
  return line;
}

}  // namespace

TEST_CASE("A simplified ring lies within the tolerance of the ring, both ways, whatever its shape") {
  RandomStream random(31, Purpose::kTest);
  for (int trial = 0; trial < 60; ++trial) {
    const int n = 200 + 20 * (trial % 11), spikes = trial % 7;
    const double noise = trial % 3 == 0 ? 0 : std::pow(10, random.uniform(0, 3.5)),
                 depth = random.uniform(0, 0.9);
    std::vector<geometry::Vec> line;
    for (int i = 0; i < n; ++i) {
      const double a = 2 * M_PI * i / n;
      const double r = 60'000 * (1 + depth * (spikes % 2 ? std::cos(spikes * a)
                                                         : std::abs(std::remainder(spikes * a, 2.0)) - 0.5));
      line.push_back(
          {r * std::cos(a) + random.uniform(-noise, noise), r * std::sin(a) + random.uniform(-noise, noise)});
    }
    for (const double tolerance : {10.0, 150.0, 350.0, 2'000.0}) {
      for (const bool few : kBoth) {
        geometry::Rings rings;
        if (!simplified(few, line, tolerance, rings)) continue;
        const auto before = closed(line), after = oracle::segments_of(rings);
        INFO("trial " << trial << ", tolerance " << tolerance << ", few " << few);
        CHECK(furthest(before, after, 100) <= tolerance + 1);
        CHECK(furthest(after, before, 100) <= tolerance + 1);
      }
    }
  }
}

// Edges of a polygon from an outer circle to itself that touch an inner one.
double edges_between(double inner, double outer) { return M_PI / std::acos(inner / outer); }

TEST_CASE("A circle takes as few edges as any closed line within the tolerance on both sides of it") {
  for (const double radius : {5'000.0, 100'000.0, 2'000'000.0})
    for (const double tolerance : {100.0, 350.0}) {
      geometry::Rings rings;
      REQUIRE(simplify_ring(circle(radius, 20'000), tolerance, rings));
      const double fewest = edges_between(radius - tolerance, radius + tolerance);
      CHECK(double(rings.points.size()) >= fewest - 1e-9);
      CHECK(double(rings.points.size()) <= 1.05 * fewest + 3);
    }
}

TEST_CASE(
    "A circle with few corners keeps its area, and takes as few as one with its corners outside by the "
    "tolerance can") {
  for (const bool hole : {false, true})
    for (const double radius : {20'000.0, 100'000.0, 2'000'000.0})
      for (const double tolerance : {100.0, 350.0}) {
        std::vector<geometry::Vec> line = circle(radius, 20'000);
        if (hole) std::reverse(line.begin(), line.end());
        geometry::Rings rings;
        REQUIRE(geometry::MinimumLinkSimplifier()(line, tolerance, rings));
        double twice_area = 0;
        for (const oracle::Segment& s : oracle::segments_of(rings)) twice_area += cross(s.a, s.b);
        // Edges lie inside at their middles by half the distance by which their ends lie outside: at most a
        // tenth of the tolerance off in all.
        CHECK(std::abs(std::abs(twice_area) / (2 * M_PI * radius * radius) - 1) <=
              2 * 0.1 * tolerance / radius);
        CHECK(double(rings.points.size()) <=
              1.08 * edges_between(radius - 0.5 * tolerance, radius + tolerance) + 3);
      }
}

TEST_CASE(
    "Places that are to stay are corners of a ring with few corners, and the rest lies within the tolerance, "
    "both ways") {
  RandomStream random(35, Purpose::kTest);
  for (int trial = 0; trial < 40; ++trial) {
    const std::size_t n = 100 + 20 * (trial % 9);
    std::vector<geometry::Vec> line;
    for (std::size_t i = 0; i < n; ++i) {
      const double a = 2 * M_PI * double(i) / double(n), r = 60'000 * (1 + 0.3 * std::cos((trial % 5) * a));
      line.push_back(
          {r * std::cos(a) + random.uniform(-200, 200), r * std::sin(a) + random.uniform(-200, 200)});
    }
    // A few runs of several places, one alone, the last and the first.
    std::vector<std::size_t> stay;
    for (std::size_t i = 0; i < n; ++i)
      if ((i % 31 < std::size_t(trial % 7)) || i == n / 2 || (trial % 3 == 0 && i + 1 == n))
        stay.push_back(i);
    const double tolerance = random.uniform(50, 600);
    geometry::Rings rings;
    REQUIRE(geometry::MinimumLinkSimplifier()(line, tolerance, rings, stay));
    INFO("trial " << trial << ", tolerance " << tolerance);
    const auto corner = [&](std::size_t i) {
      return std::count(rings.points.begin(), rings.points.end(), geometry::to_point(line[i])) > 0;
    };
    CHECK(std::all_of(stay.begin(), stay.end(), corner));
    CHECK(rings.points.size() < n);
    CHECK(furthest(closed(line), oracle::segments_of(rings), 100) <= tolerance + 1);
    CHECK(furthest(oracle::segments_of(rings), closed(line), 100) <= tolerance + 1);
  }
}

TEST_CASE("Corners between straight edges stay where they are") {
  std::vector<geometry::Vec> line;
  const geometry::Vec corners[] = {{0, 0},           {90'000, 0},      {90'000, 40'000},
                                   {50'000, 40'000}, {50'000, 70'000}, {-20'000, 70'000}};
  for (int c = 0; c < 6; ++c)
    for (int i = 0; i < 20; ++i)
      line.push_back(corners[c] + (i / 20.0) * (corners[(c + 1) % 6] - corners[c]));
  std::vector<geometry::Point> expected;
  for (const geometry::Vec c : corners) expected.push_back(geometry::to_point(c));
  for (const bool few : kBoth) {
    geometry::Rings rings;
    REQUIRE(simplified(few, line, 350, rings));
    CHECK(rings.points == expected);
  }
}

TEST_CASE("Edges of a polygon stay where they are, however little it bends at its corners") {
  for (const int corners : {5, 12, 40}) {
    std::vector<geometry::Vec> line;
    std::vector<geometry::Point> expected;
    for (int c = 0; c < corners; ++c) {
      const auto at = [&](int i) {
        return to_vec(geometry::to_point(circle(500'000, corners)[std::size_t(i % corners)]));
      };
      expected.push_back(geometry::to_point(at(c)));
      for (int i = 0; i < 8; ++i) line.push_back(at(c) + (i / 8.0) * (at(c + 1) - at(c)));
    }
    for (const bool few : kBoth) {
      geometry::Rings rings;
      REQUIRE(simplified(few, line, 200, rings));
      CHECK(rings.points == expected);
    }
  }
}

// By brute force: paths from the line's first place along all of it, with corners on eleven places across the
// way at each place.
TEST_CASE(
    "A rough line gets three per cent more corners at most than the best of all paths with corners at its "
    "places") {
  RandomStream random(32, Purpose::kTest);
  const double tolerance = 200;
  int ours = 0, best = 0, cones = 0;
  for (int trial = 0; trial < 12; ++trial) {
    std::vector<geometry::Vec> line = circle(random.uniform(20'000, 80'000), 120 + 10 * trial);
    for (geometry::Vec& v : line) v = (1 + random.uniform(-1, 1) * 260 / length(v)) * v;
    const int n = int(line.size()), heights = 11;
    const auto corner = [&](int i, int h) {
      const geometry::Vec at = line[std::size_t(i % n)];
      return i == 0 || i == n ? at : (1 + (h - heights / 2) * 0.2 * tolerance / length(at)) * at;
    };
    std::vector<int> edges(std::size_t((n + 1) * heights), std::numeric_limits<int>::max());
    for (int h = 0; h < heights; ++h) edges[std::size_t(h)] = 0;
    for (int i = 0; i < n; ++i)
      for (int h = 0; h < heights; ++h) {
        const int here = edges[std::size_t(i * heights + h)];
        if (here == std::numeric_limits<int>::max()) continue;
        for (int j = i + 1; j <= std::min(n, i + 40); ++j)
          for (int k = 0; k < heights; ++k) {
            int& there = edges[std::size_t(j * heights + k)];
            if (there <= here + 1) continue;
            const oracle::Segment edge{corner(i, h), corner(j, k)};
            bool within = true;
            for (int m = i + 1; m < j && within; ++m)
              within = oracle::distance(line[std::size_t(m)], edge) <= tolerance;
            if (within) there = here + 1;
          }
      }
    best += edges[std::size_t(n * heights)];
    geometry::Rings rings, by_cone;
    REQUIRE(simplified(true, line, tolerance, rings));
    REQUIRE(simplified(false, line, tolerance, by_cone));
    ours += int(rings.points.size());
    cones += int(by_cone.points.size());
  }
  INFO("ours " << ours << ", brute force " << best << ", cone " << cones);
  CHECK(ours <= 1.03 * best);
  CHECK(ours < 0.85 * cones);
}

TEST_CASE("What would lose its area keeps its points, what has none is left out") {
  geometry::Rings rings;
  CHECK(simplify_ring(std::vector<geometry::Vec>{{0, 0}, {1'000, -20}, {2'000, 0}, {1'500, 10}, {1'000, 20}},
                      350, rings));
  CHECK(rings.points.size() == 5);
  CHECK_FALSE(simplify_ring(
      std::vector<geometry::Vec>{{0, 0}, {1'000, 0}, {2'000, 0}, {1'500, 0}, {1'000, 0}}, 350, rings));
  CHECK(rings.size() == 1);
}
