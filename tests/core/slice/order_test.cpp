// The order of a layer's paths against a search through all that are left, and the work it takes.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "core/geometry/point_measures.h"
#include "core/grid/random.h"
#include "core/slice/paths/nearest_start.h"
#include "core/slice/paths/order.h"
#include "tests/core/slice/outlines.h"

using namespace firn;
using namespace firn::slice;
using geometry::Point;

namespace {

// Nearest neighbour by its definition. Of several at the same distance the first one behind the line taken
// last, in a cycle, and of its points the first.
LayerPaths by_all_starts(const geometry::Rings& lines, bool closed, SeamPlacement seam, Point at) {
  LayerPaths out;
  std::vector<bool> done(lines.size());
  for (std::size_t next = 0, n = 0; n < lines.size(); ++n) {
    double best = std::numeric_limits<double>::infinity();
    std::size_t chosen = 0, first = 0;
    for (std::size_t k = 0; k < lines.size(); ++k) {
      const std::size_t i = (next + k) % lines.size();
      if (done[i]) continue;
      const auto line = lines[i];
      const auto lowest = std::ranges::min_element(line, {}, [](Point p) { return std::pair(p.y, p.x); });
      for (std::size_t p = 0; p < line.size(); ++p) {
        if (!closed && p > 0 && p + 1 < line.size()) continue;
        if (closed && seam == SeamPlacement::kAligned && p != std::size_t(lowest - line.begin())) continue;
        if (const double d = square_distance(line[p], at); d < best) {
          best = d;
          chosen = i;
          first = p;
        }
      }
    }
    std::vector<Point> line(lines[chosen].begin(), lines[chosen].end());
    if (closed)
      std::rotate(line.begin(), line.begin() + std::ptrdiff_t(first), line.end());
    else if (first > 0)
      std::ranges::reverse(line);
    out.lines.add(line);
    at = closed ? line.front() : line.back();
    done[chosen] = true;
    next = chosen + 1;
  }
  return out;
}

Point random_point(RandomStream& random, std::int32_t room) {
  const auto number = [&] { return std::int32_t((random.uniform() - 0.5) * room); };
  const std::int32_t x = number();
  return {x, number()};
}

void add_ring(geometry::Rings& rings, Point about, double radius, std::size_t points) {
  std::vector<Point> ring;
  for (std::size_t k = 0; k < points; ++k) {
    const double turn = 2 * std::numbers::pi * double(k) / double(points);
    ring.push_back({about.x + std::int32_t(std::lround(radius * std::cos(turn))),
                    about.y + std::int32_t(std::lround(radius * std::sin(turn)))});
  }
  rings.add(ring);
}

void add_line(geometry::Rings& lines, Point a, Point b) {
  const Point line[] = {a, b};
  lines.add(line);
}

constexpr std::int32_t kPitch = 30000, kWidth = 15000;

enum class Kind { kLattice, kScattered, kNested, kStraight, kSloping, kShuffled };

// n lines of a kind that layers have.
geometry::Rings lines_of(Kind kind, std::int32_t n) {
  geometry::Rings lines;
  RandomStream random(11, Purpose::kTest);
  const std::int32_t side = std::int32_t(std::lround(std::sqrt(n)));
  for (std::int32_t i = 0; i < n; ++i) {
    const Point cell{i / side * kPitch, i % side * kPitch};
    switch (kind) {
      case Kind::kLattice:
        add_ring(lines, cell, 0.25 * kPitch, 24);
        break;
      case Kind::kScattered:
        add_ring(lines, random_point(random, side * kPitch), 0.1 * kPitch, 12);
        break;
      case Kind::kNested:
        add_ring(lines, {}, kPitch * (i + 1), 24);
        break;
      case Kind::kStraight:
        add_line(lines, {i * kPitch, 0}, {i * kPitch, 1000 * kPitch});
        break;
      case Kind::kSloping:
        add_line(lines, {i * kPitch, 0}, {(i + 900) * kPitch, 1000 * kPitch});
        break;
      case Kind::kShuffled: {
        const Point at = random_point(random, side * kPitch);
        add_line(lines, at, {at.x + kPitch, at.y + kPitch / 2});
      }
    }
  }
  return lines;
}

std::uint64_t starts_looked_at(const geometry::Rings& lines, bool closed) {
  std::vector<NearestStart::Starts> starts;
  for (std::uint32_t i = 0; i < lines.size(); ++i) {
    const std::uint32_t size = std::uint32_t(lines[i].size());
    if (closed) {
      NearestStart::add_all(lines, i, 8 * kWidth, starts);
    } else {
      for (const std::uint32_t p : {0u, size - 1}) starts.push_back({i, p, p + 1});
    }
  }
  NearestStart nearest(lines, starts);
  for (Point at{}; !nearest.empty();) {
    const auto [line, point] = nearest.take(at);
    at = closed ? lines[line][point] : point > 0 ? lines[line].front() : lines[line].back();
  }
  return nearest.looked_at();
}

}  // namespace

TEST_CASE("The nearest path comes next, as a search through all start points finds it, ties too") {
  RandomStream random(5, Purpose::kTest);
  for (int round = 0; round < 400; ++round) {
    const bool closed = round % 2, tight = round % 4 < 2;
    const SeamPlacement seam = round % 8 < 4 ? SeamPlacement::kNearest : SeamPlacement::kAligned;
    const std::int32_t room = tight ? 12 : 2'000'000'000;  // a few units: nearly every choice is a tie
    geometry::Rings lines;
    for (std::size_t i = 0, count = random.below(round % 20 ? 90 : 700); i < count; ++i) {
      std::vector<Point> line(2 + closed + random.below(round % 3 ? 4 : 60));
      for (Point& p : line) p = random_point(random, room);
      lines.add(line);
    }
    PathOptions options;
    options.seam = seam;
    options.two_opt_passes = 0;
    LayerPaths paths;
    const Point from = random_point(random, room);
    Point at = from;
    append_in_order(lines, {PathKind::kFill, 0, closed, 30000}, options, at, paths);
    INFO("round " << round << ", " << lines.size() << " lines");
    REQUIRE(paths.lines == by_all_starts(lines, closed, seam, from).lines);
    if (!lines.empty()) {
      const auto last = paths.lines[paths.lines.size() - 1];
      REQUIRE(at == (closed ? last.front() : last.back()));
    }
  }
}

TEST_CASE("Four times as many paths take at most 4^1.1 times as many looks at start points") {
  for (const Kind kind :
       {Kind::kLattice, Kind::kScattered, Kind::kNested, Kind::kStraight, Kind::kSloping, Kind::kShuffled}) {
    const bool closed = kind < Kind::kStraight;
    constexpr std::int32_t kLines = 4000;
    std::uint64_t looks[3];
    for (int k = 0; k < 3; ++k) looks[k] = starts_looked_at(lines_of(kind, kLines << k), closed);
    INFO("kind " << int(kind) << ": " << looks[0] << ", " << looks[1] << ", " << looks[2]);
    CHECK(double(looks[2]) <= std::pow(4, 1.1) * double(looks[0]));
    CHECK(looks[0] <= kLines * 24 * 8);  // and few of each path's own
  }
}
