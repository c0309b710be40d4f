// Every level of rings of every STEPth layer from layer FIRST on against the exact offset of the mesh's own
// contours, by definition (tests/core/slice/offset_oracle.h), every 0.025 mm, both ways:
//   build/bench/slice_exactness MESH [FIRST [STEP]]
// for a chord tolerance of 0.05 mm shared as a job shares it. Prints the levels that are further off
// anywhere.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "core/slice/mesh/slicer.h"
#include "core/slice/offset/offset_rings.h"
#include "core/slice/paths/path_options.h"
#include "files/mesh/mesh_file.h"
#include "tests/bench/bench.h"
#include "tests/core/slice/offset_oracle.h"

namespace firn::bench::slice_exactness {

using namespace firn;
using namespace firn::slice;

FIRN_BENCH(slice_exactness) try {
  if (argc < 2) {
    std::fprintf(stderr, "usage: %s MESH [FIRST [STEP]]\n", argv[0]);
    return 2;
  }
  const int first = argc > 2 ? std::atoi(argv[2]) : 4, step = argc > 3 ? std::atoi(argv[3]) : 13;
  if (first < 1 || step < 1) {
    std::fprintf(stderr, "%s: FIRST and STEP are layers, 1 or more\n", argv[0]);
    return 2;
  }
  const double tolerance_mm = 0.05, filter_mm = kOutlineShare * tolerance_mm,
               ring_mm = kRingShare * tolerance_mm;
  const double most = tolerance_mm * geometry::kUnitsPerMm, every = 250;
  const MeshFile mesh(argv[1]);
  const auto sliced = [&](double chord_mm) {
    return slice::slice(mesh.facets(), {}, {.chord_tolerance_mm = chord_mm}, serially);
  };
  const Sliced thin = sliced(filter_mm), whole = sliced(0);
  std::size_t levels = 0, off = 0;
  double furthest = 0;
  for (std::size_t k = std::size_t(first) - 1; k < thin.layers.size(); k += std::size_t(step)) {
    const RingPlan plan;
    const RingLevels rings =
        offset_rings(thin.layers[k], plan, ring_mm, 0, {&whole.layers[k], filter_mm, true});
    for (std::size_t level = 0; level < rings.levels.size(); ++level) {
      const double d = plan.distance_mm(int(level)) * geometry::kUnitsPerMm;
      const oracle::Nearby outline(oracle::segments_of(whole.layers[k]), d + 2000);
      double depth = 0;
      for (const geometry::Vec p : oracle::along(rings.levels[level], every))
        depth = std::max(depth, std::abs(outline.distance_to(p) - d));
      const oracle::Hausdorff h = oracle::hausdorff(whole.layers[k], rings.levels[level], d, every, 3000);
      ++levels;
      furthest = std::max(furthest, depth);
      if (depth <= most && h.exact_to_ring <= most && h.ring_to_exact <= std::hypot(most, 0.5 * every))
        continue;
      ++off;
      std::printf(
          "layer %zu, level %zu: depth off by %.4f mm, exact to ring %.4f mm, ring to exact %.4f mm\n", k + 1,
          level, depth * geometry::kMmPerUnit, h.exact_to_ring * geometry::kMmPerUnit,
          h.ring_to_exact * geometry::kMmPerUnit);
    }
  }
  std::printf("%s: %zu levels, %zu further off than %g mm; depth off by %.4f mm at most\n", argv[1], levels,
              off, tolerance_mm, furthest * geometry::kMmPerUnit);
  return 0;
} catch (const std::exception& e) {
  std::fprintf(stderr, "%s: %s\n", argv[0], e.what());
  return 1;
}

}  // namespace firn::bench::slice_exactness
