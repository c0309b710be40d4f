#include "core/slice/scaffold.h"

#include <algorithm>
#include <cmath>

#include "core/slice/clipper.h"
#include "core/slice/offset_rings.h"

namespace firn::slice {
namespace {

// [k]: union of layer k and all above.
std::vector<Region> merged_above(std::span<const Region> part) {
  std::vector<Region> merged(part.size());
  for (std::size_t k = part.size(); k-- > 0;)
    merged[k] = k + 1 < part.size() ? clipper_unite(merged[k + 1], part[k]) : part[k];
  return merged;
}

// [k]: what of the layers above leans out further than `lean_mm` a layer and has no part between it and layer k.
std::vector<Region> overhanging(std::span<const Region> part, double lean_mm, double tolerance_mm,
                                const ParallelFor& parallel) {
  std::vector<Region> fresh(part.size()), need(part.size());
  parallel(int(part.size()) - 1, [&](int k) {
    const Region carried = grow(part[std::size_t(k)], lean_mm, std::min(tolerance_mm, 0.1 * lean_mm));
    fresh[std::size_t(k)] = clipper_subtract(part[std::size_t(k) + 1], lean_mm > 0 ? carried : part[std::size_t(k)]);
  });
  for (std::size_t k = part.size(); k-- > 1;)
    need[k - 1] = clipper_unite(clipper_subtract(need[k], part[k]), fresh[k - 1]);
  return need;
}

}  // namespace

std::vector<Region> scaffold_regions(std::span<const Region> part, std::int32_t height, const SupportOptions& options,
                                     double chord_tolerance_mm, const ParallelFor& parallel) {
  std::vector<Region> scaffold(part.size());
  if (options.kind == Support::kNone || part.empty()) return scaffold;
  const double lean_mm = height * kMmPerUnit * std::tan(options.overhang_rad);
  const std::vector<Region> above = options.kind == Support::kFull
                                        ? merged_above(part)
                                        : overhanging(part, lean_mm, chord_tolerance_mm, parallel);
  // Grow by less, so that no approximation reaches further than the buffer.
  const double grow_mm = std::max(0.0, options.buffer_mm - chord_tolerance_mm - 1e-3);
  parallel(int(part.size()), [&](int layer) {
    const std::size_t k = std::size_t(layer);
    const Region grown = grow_mm > 0 ? grow(above[k], grow_mm, chord_tolerance_mm) : above[k];
    scaffold[k] = clipper_subtract(grown, part[k]);
  });
  return scaffold;
}

}  // namespace firn::slice
