#include "core/slice/support/scaffold.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/exact/exact_math.h"
#include "core/geometry/planar.h"
#include "core/geometry/simplify_ring.h"
#include "core/geometry/tolerant_boolean.h"
#include "core/slice/offset/offset_rings.h"
#include "core/slice/support/overhang.h"

namespace firn::slice {
namespace {

constexpr std::size_t kLayersAtOnce = 32;

// Calls use(first, behind, union) for all layers, from the top in blocks: layers [first, behind) have this
// union of a layer and all above, except for a rim of `slack` units. The union is computed downward through
// one block while the one above it is used.
template <class Use>
void for_merged_above(std::span<const geometry::Region> part, std::int32_t slack, const ParallelFor& parallel,
                      const Use& use) {
  struct Merged {
    std::size_t first, behind;
    geometry::Region above;
  };
  std::vector<Merged> merged, before;  // from the top
  geometry::Region last;
  for (std::size_t begin = 0, used = 0; used < part.size();
       used = begin, begin = std::min(part.size(), begin + kLayersAtOnce)) {
    const std::size_t end = std::min(part.size(), begin + kLayersAtOnce);
    std::swap(merged, before);
    parallel(1 + int(before.size()), [&](int n) {
      if (n > 0) {
        const Merged& m = before[std::size_t(n) - 1];
        return use(m.first, m.behind, m.above);
      }
      merged.clear();
      for (std::size_t down = begin; down < end; ++down) {
        const std::size_t k = part.size() - 1 - down;
        geometry::Region next = down ? union_within(last, part[k], slack) : part[k];
        if (!merged.empty() && next == last)
          merged.back().first = k;
        else
          merged.push_back({k, k + 1, next});
        last = std::move(next);
      }
    });
  }
}

geometry::Region simplified(const geometry::Region& region, double tolerance_mm) {
  if (tolerance_mm <= 0) return region;
  geometry::Region simple;
  std::vector<geometry::Vec> line;
  for (std::size_t r = 0; r < region.size(); ++r) {
    line.clear();
    for (const geometry::Point p : region[r]) line.push_back(to_vec(p));
    simplify_ring(line, tolerance_mm * geometry::kUnitsPerMm, simple);
  }
  return simple;
}

// Returns a region minus a smaller one that lies inside it.
geometry::Region between(const geometry::Region& outer, const geometry::Region& inner) {
  geometry::Region region = outer;
  std::vector<geometry::Point> ring;
  for (std::size_t r = 0; r < inner.size(); ++r) {
    ring.assign(inner[r].rbegin(), inner[r].rend());
    region.add(ring);
  }
  return canonical(region);
}

}  // namespace

std::vector<geometry::Region> scaffold_regions(std::span<const geometry::Region> part, std::int32_t height,
                                               const SupportOptions& options, double chord_tolerance_mm,
                                               const ParallelFor& parallel) {
  std::vector<geometry::Region> scaffold(part.size());
  if (options.kind == Support::kNone || part.empty()) return scaffold;
  const double lean_mm = height * geometry::kMmPerUnit * exact::tan(options.overhang_rad);
  // Simplification and drawing may each add the tolerance: nothing may extend beyond the buffer.
  const double grow_mm = std::max(0.0, options.buffer_mm - 2 * chord_tolerance_mm - 1e-3);
  if (options.kind == Support::kFull) {
    const std::int32_t slack = std::int32_t(0.5 * chord_tolerance_mm * geometry::kUnitsPerMm);
    for_merged_above(
        part, slack, parallel, [&](std::size_t first, std::size_t behind, const geometry::Region& above) {
          const geometry::Region grown =
              grow(simplified(above, chord_tolerance_mm), grow_mm, chord_tolerance_mm);
          // Rings of the layer and of the area outside it do not intersect.
          for (std::size_t k = first; k < behind; ++k)
            scaffold[k] =
                grow_mm > 4 * chord_tolerance_mm + 0.01 ? between(grown, part[k]) : subtract(grown, part[k]);
        });
    return scaffold;
  }
  const double seam_mm = 0.3 * std::min(options.buffer_mm, 3.3);
  const double around_mm = std::max(0.0, grow_mm - seam_mm);
  for_overhanging(part, {lean_mm, seam_mm, chord_tolerance_mm}, parallel,
                  [&](std::size_t k, const geometry::Region& above) {
                    if (above.empty()) return;
                    const geometry::Region under =
                        around_mm > 0 ? grow(above, around_mm, chord_tolerance_mm) : above;
                    scaffold[k] = subtract(under, part[k]);
                  });
  return scaffold;
}

}  // namespace firn::slice
