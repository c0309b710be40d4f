// Rings of rough hourglasses whose waists are about as wide as two sides of a ring, so that the thinning
// decides whether they part, against the exact offset of their contours by definition
// (tests/core/slice/offset_oracle.h), every 0.025 mm, both ways:
//   build/bench/slice_straits [TRIALS [SEED]]
// for a chord tolerance of 0.05 mm shared as a job shares it. Prints those that are further off, and how far
// the strait is open where it has no ring, and closed where it has one: the distance of its middle from the
// contours less that of the ring.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "core/geometry/planar.h"
#include "core/slice/mesh/path_filter.h"
#include "core/slice/offset/offset_rings.h"
#include "core/slice/paths/path_options.h"
#include "tests/bench/bench.h"
#include "tests/core/slice/offset_oracle.h"
#include "tests/core/slice/outlines.h"

namespace firn::bench::slice_straits {

using namespace firn;
using namespace firn::slice;

namespace {

// How far a strait, which runs along x, is open at a place: the largest distance of a point across from the
// contours less d, in steps of 0.5 um.
double opening(const oracle::Nearby& outline, geometry::Vec place, double d) {
  const double across = 5, half_width = 500;
  double widest = -2 * half_width;
  for (double y = place.y - half_width; y <= place.y + half_width; y += across)
    widest = std::max(widest, outline.distance_to({place.x, y}) - d);
  return widest;
}

// The largest opening of parts of the exact offset that have no ring near, and of rings the largest closing
// where the exact offset is far.
struct Worst {
  double open_without_ring = 0, closed_with_ring = 0;  // units
};

Worst worst(const geometry::Region& contours, const geometry::Rings& rings, double d, double most,
            double every) {
  const std::vector<geometry::Vec> exact = oracle::exact_offset(contours, d, every);
  std::vector<oracle::Segment> points;
  for (const geometry::Vec p : exact) points.push_back({p, p});
  const oracle::Nearby exact_near(points, 6000), rings_near(oracle::segments_of(rings), 6000),
      outline(oracle::segments_of(contours), d + 1000);
  Worst found;
  for (const geometry::Vec p : exact)
    if (rings_near.distance_to(p) > most)
      found.open_without_ring = std::max(found.open_without_ring, opening(outline, p, d));
  for (const geometry::Vec p : oracle::along(rings, every))
    if (exact_near.distance_to(p) > std::hypot(most, 0.5 * every))
      found.closed_with_ring = std::max(found.closed_with_ring, -opening(outline, p, d));
  return found;
}

}  // namespace

FIRN_BENCH(slice_straits) {
  const int trials = argc > 1 ? std::atoi(argv[1]) : 900, seed = argc > 2 ? std::atoi(argv[2]) : 74;
  if (trials < 1 || seed < 0) {
    std::fprintf(stderr, "usage: %s [TRIALS [SEED]], 1 or more and 0 or more\n", argv[0]);
    return 2;
  }
  const double tolerance_mm = 0.05, filter_mm = kOutlineShare * tolerance_mm,
               most = tolerance_mm * geometry::kUnitsPerMm, every = 250;
  RandomStream random(std::uint64_t(seed), Purpose::kTest);
  int levels = 0, off = 0;
  for (int trial = 0; trial < trials; ++trial) {
    const RingPlan plan;
    const geometry::Rings contours = outlines::hourglass(plan.distance_mm(trial % 3), random);
    geometry::Rings outline;
    PathFilter(0, filter_mm * geometry::kUnitsPerMm).append(contours[0], outline);
    const RingLevels rings =
        offset_rings(region_of(outline), plan, kRingShare * tolerance_mm, 0, {&contours, filter_mm, true});
    for (std::size_t level = 0; level < rings.levels.size(); ++level, ++levels) {
      const double d = plan.distance_mm(int(level)) * geometry::kUnitsPerMm;
      const oracle::Hausdorff h = oracle::hausdorff(contours, rings.levels[level], d, every, 6000);
      if (h.exact_to_ring <= most && h.ring_to_exact <= std::hypot(most, 0.5 * every)) continue;
      ++off;
      const Worst open = worst(contours, rings.levels[level], d, most, every);
      std::printf(
          "hourglass %d, level %zu: exact to ring %.4f mm, ring to exact %.4f mm; "
          "open without a ring by %.2f um, closed with one by %.2f um\n",
          trial, level, h.exact_to_ring * geometry::kMmPerUnit, h.ring_to_exact * geometry::kMmPerUnit,
          1e3 * geometry::kMmPerUnit * open.open_without_ring,
          1e3 * geometry::kMmPerUnit * open.closed_with_ring);
    }
  }
  std::printf("%d hourglasses, %d levels, %d further off than %g mm\n", trials, levels, off, tolerance_mm);
  return 0;
}

}  // namespace firn::bench::slice_straits
