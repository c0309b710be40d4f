// Rings of rough hourglasses whose waists are about as wide as two sides of a ring, so that the thinning
// decides whether they part, against the exact offset of their contours by definition
// (tests/core/slice/offset_oracle.h), every 0.025 mm, both ways:
//   build/bench/slice_straits [TRIALS [SEED]]
// for a chord tolerance of 0.05 mm shared as a job shares it. Prints those that are further off.
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
      std::printf("hourglass %d, level %zu: exact to ring %.4f mm, ring to exact %.4f mm\n", trial, level,
                  h.exact_to_ring * kMmPerUnit, h.ring_to_exact * kMmPerUnit);
    }
  }
  std::printf("%d hourglasses, %d levels, %d further off than %g mm\n", trials, levels, off, tolerance_mm);
  return 0;
}
