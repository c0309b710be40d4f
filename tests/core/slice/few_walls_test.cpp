#include "core/slice/medial/few_walls.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/grid/random.h"

namespace firn::slice {
namespace {

constexpr double kFacing = -0.174;

// A crooked line of walls some mm long, far from the origin.
std::vector<Wall> crooked(RandomStream& random, std::size_t count) {
  std::vector<Wall> walls;
  Vec at{2e6 * random.uniform(), 2e6 * random.uniform()};
  double begin = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec way{2e4 * (random.uniform() - 0.5), 2e4 * (random.uniform() - 0.5)};
    const double l = length(way);
    walls.push_back({at, at + way, (1 / l) * left_of(way), begin, l, true});
    at = at + way, begin += l;
  }
  return walls;
}

// Radius of the disc that touches the foot and the wall, or the corner where it begins; -1: they do not face
// each other.
double radius_of(const Foot& foot, const Wall& w) {
  double best = -1;
  const auto offer = [&](double radius) { best = best < 0 ? radius : std::min(best, radius); };
  const Vec off = w.from - foot.at;
  const double ahead = dot(off, foot.normal), distance = length(off);
  // The corner's normal points from it to the disc's centre.
  if (ahead > 0 && 1 - 2 * (ahead / distance) * (ahead / distance) <= kFacing)
    offer(dot(off, off) / (2 * ahead));
  const double opening = 1 - dot(foot.normal, w.normal), height = -dot(off, w.normal);
  if (opening >= 1 - kFacing && height >= 0) {
    const Vec centre = foot.at + (height / opening) * foot.normal;
    const double along = dot(centre - w.from, w.to - w.from) / w.length;
    if (along >= 0 && along <= w.length) offer(height / opening);
  }
  return best;
}

TEST_CASE(
    "Few walls, asked four at a time, tell the wall opposite a foot and the nearest one as one by one, to "
    "0.1 um") {
  RandomStream random(20261122, Purpose::kTest);
  int found = 0;
  for (int round = 0; round < 400; ++round) {
    const std::vector<Wall> walls = crooked(random, 1 + std::size_t(round) % FewWalls::kMost);
    FewWalls few;
    few.take(walls);
    for (int k = 0; k < 10; ++k) {
      const Wall& at = walls[std::size_t(random.uniform() * double(walls.size()))];
      const Foot foot{at.from + random.uniform() * (at.to - at.from), at.normal, 0, 0};
      const double limit = 5e4 * random.uniform();
      double least = limit;
      for (const Wall& w : walls)
        if (const double radius = radius_of(foot, w); radius > 1 && radius < least) least = radius;
      const std::size_t wall = few.opposite(foot, kFacing, limit);
      // The foot's own wall touches it: whatever rounding makes of that is no disc of any size.
      const double told = wall < walls.size() ? radius_of(foot, walls[wall]) : limit;
      if (told > 1) CHECK(std::abs(told - least) <= 1);
      found += told > 1 && told < limit;
      double nearest = 1e12;
      for (const Wall& w : walls)
        nearest = std::min(nearest, square_distance(foot.at + limit * foot.normal, w.from, w.to));
      CHECK(std::abs(std::sqrt(few.square_depth(foot.at + limit * foot.normal)) - std::sqrt(nearest)) <= 1);
    }
  }
  CHECK(found > 1000);
}

}  // namespace
}  // namespace firn::slice
