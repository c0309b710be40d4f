// Rings of rough hourglasses whose waists are about as wide as two sides of a ring, so that the thinning
// decides whether they part, against the exact offset of their contours by definition
// (tests/core/slice/offset_oracle.h), every 0.025 mm, both ways:
//   build/bench/slice_straits [TRIALS [SEED]]
// for a chord tolerance of 0.05 mm shared as a job shares it. Prints those that are further off, and how far
// the strait is open (below 0: closed) there: the distance of its middle from the contours less that of the
// ring.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "core/geometry/planar.h"
#include "core/slice/mesh/path_filter.h"
#include "core/slice/offset/offset_rings.h"
#include "core/slice/paths/path_options.h"
#include "tests/core/slice/offset_oracle.h"
#include "tests/core/slice/outlines.h"

using namespace firn;
using namespace firn::slice;

namespace {

struct Opening {
  double least, most;  // units
};

// Examines the middle of a strait, which runs along x, within `reach` of a place, with steps of 0.01 mm along
// and 0.5 um across.
Opening opening(const Region& contours, Vec place, double d, double reach) {
  const double along = 100, across = 5, half_width = 500;
  const oracle::Nearby outline(oracle::segments_of(contours), d + 2 * half_width);
  Opening found{2 * half_width, -2 * half_width};
  for (double x = place.x - reach; x <= place.x + reach; x += along) {
    double widest = -2 * half_width;
    for (double y = place.y - half_width; y <= place.y + half_width; y += across)
      widest = std::max(widest, outline.distance_to({x, y}) - d);
    found.least = std::min(found.least, widest);
    found.most = std::max(found.most, widest);
  }
  return found;
}

}  // namespace

int main(int argc, char** argv) {
  const int trials = argc > 1 ? std::atoi(argv[1]) : 900, seed = argc > 2 ? std::atoi(argv[2]) : 74;
  if (trials < 1 || seed < 0) {
    std::fprintf(stderr, "usage: %s [TRIALS [SEED]], 1 or more and 0 or more\n", argv[0]);
    return 2;
  }
  const double tolerance_mm = 0.05, filter_mm = kOutlineShare * tolerance_mm,
               most = tolerance_mm * kUnitsPerMm, every = 250;
  RandomStream random(std::uint64_t(seed), Purpose::kTest);
  int levels = 0, off = 0;
  for (int trial = 0; trial < trials; ++trial) {
    const RingPlan plan;
    const Rings contours = outlines::hourglass(plan.distance_mm(trial % 3), random);
    Rings outline;
    PathFilter(0, filter_mm * kUnitsPerMm).append(contours[0], outline);
    const RingLevels rings =
        offset_rings(region_of(outline), plan, kRingShare * tolerance_mm, 0, {&contours, filter_mm, true});
    for (std::size_t level = 0; level < rings.levels.size(); ++level, ++levels) {
      const double d = plan.distance_mm(int(level)) * kUnitsPerMm;
      const oracle::Hausdorff h = oracle::hausdorff(contours, rings.levels[level], d, every, 6000);
      if (h.exact_to_ring <= most && h.ring_to_exact <= std::hypot(most, 0.5 * every)) continue;
      ++off;
      const bool missing = h.exact_to_ring > most;
      const Opening open = missing ? opening(contours, h.exact_place, d, every)
                                   : opening(contours, h.ring_place, d, h.ring_to_exact - every);
      std::printf(
          "hourglass %d, level %zu: exact to ring %.4f mm, ring to exact %.4f mm; %s, "
          "open by %.2f um\n",
          trial, level, h.exact_to_ring * kMmPerUnit, h.ring_to_exact * kMmPerUnit,
          missing ? "no ring" : "a ring", 1e3 * kMmPerUnit * (missing ? open.most : open.least));
    }
  }
  std::printf("%d hourglasses, %d levels, %d further off than %g mm\n", trials, levels, off, tolerance_mm);
  return 0;
}
