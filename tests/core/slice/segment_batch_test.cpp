#include "core/slice/medial/segment_batch.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/grid/random.h"

namespace firn::slice {
namespace {

constexpr double kFacing = -0.174;

// A crooked line of segments some mm long, far from the origin.
std::vector<BoundarySegment> crooked(RandomStream& random, std::size_t count) {
  std::vector<BoundarySegment> segments;
  geometry::Vec at{2e6 * random.uniform(), 2e6 * random.uniform()};
  double begin = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const geometry::Vec way{2e4 * (random.uniform() - 0.5), 2e4 * (random.uniform() - 0.5)};
    const double l = length(way);
    segments.push_back({at, at + way, (1 / l) * left_of(way), begin, l, true});
    at = at + way;
    begin += l;
  }
  return segments;
}

// Radius of the disc that touches the sample and the segment, or the corner where it begins; -1: they do not
// face each other.
double radius_of(const BoundarySample& sample, const BoundarySegment& w) {
  double best = -1;
  const auto offer = [&](double radius) { best = best < 0 ? radius : std::min(best, radius); };
  const geometry::Vec off = w.from - sample.at;
  const double ahead = dot(off, sample.normal), distance = length(off);
  // The corner's normal points from it to the disc's centre.
  if (ahead > 0 && 1 - 2 * (ahead / distance) * (ahead / distance) <= kFacing)
    offer(dot(off, off) / (2 * ahead));
  const double opening = 1 - dot(sample.normal, w.normal), height = -dot(off, w.normal);
  if (opening >= 1 - kFacing && height >= 0) {
    const geometry::Vec centre = sample.at + (height / opening) * sample.normal;
    const double along = dot(centre - w.from, w.to - w.from) / w.length;
    if (along >= 0 && along <= w.length) offer(height / opening);
  }
  return best;
}

TEST_CASE(
    "Few segments, asked four at a time, tell the segment opposite a sample and the nearest one as one by "
    "one, to "
    "0.1 um") {
  RandomStream random(20261122, Purpose::kTest);
  int found = 0;
  for (int round = 0; round < 400; ++round) {
    const std::vector<BoundarySegment> segments =
        crooked(random, 1 + std::size_t(round) % SegmentBatch::kMaxSegments);
    SegmentBatch few;
    few.take(segments);
    for (int k = 0; k < 10; ++k) {
      const BoundarySegment& at = segments[std::size_t(random.uniform() * double(segments.size()))];
      const BoundarySample sample{at.from + random.uniform() * (at.to - at.from), at.normal, 0, 0};
      const double limit = 5e4 * random.uniform();
      double least = limit;
      for (const BoundarySegment& w : segments)
        if (const double radius = radius_of(sample, w); radius > 1 && radius < least) least = radius;
      const std::size_t segment = few.opposite(sample, kFacing, limit);
      // The segment of the sample touches it: its disc is a rounding error.
      const double found_radius = segment < segments.size() ? radius_of(sample, segments[segment]) : limit;
      if (found_radius > 1) CHECK(std::abs(found_radius - least) <= 1);
      found += found_radius > 1 && found_radius < limit;
      double nearest = 1e12;
      for (const BoundarySegment& w : segments)
        nearest = std::min(nearest, square_distance(sample.at + limit * sample.normal, w.from, w.to));
      CHECK(std::abs(std::sqrt(few.square_depth(sample.at + limit * sample.normal)) - std::sqrt(nearest)) <=
            1);
    }
  }
  CHECK(found > 1000);
}

}  // namespace
}  // namespace firn::slice
