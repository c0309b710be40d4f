#include "core/slice/support/overhang.h"

#include <algorithm>
#include <vector>

#include "core/geometry/tolerant_boolean.h"
#include "core/slice/offset/offset_rings.h"

namespace firn::slice {
namespace {

constexpr std::size_t kLayersOfBlock = 32;

geometry::Region grown(const geometry::Region& region, double mm, double tolerance_mm) {
  return mm > 0 ? grow(region, mm, tolerance_mm) : region;
}

class Steps {
 public:
  Steps(std::span<const geometry::Region> part, const OverhangOptions& options) : part_(part), o_(options) {
    slack_ = std::int32_t(0.25 * o_.seam_mm * geometry::kUnitsPerMm);
    lean_tolerance_mm_ = std::min(o_.tolerance_mm, 0.05 * o_.lean_mm);
    fine_mm_ = std::min(o_.tolerance_mm, 0.125 * o_.seam_mm);
  }

  // Returns the area of layer k that overhangs layer k - 1.
  geometry::Region begins(std::size_t k) const {
    const geometry::Region out =
        difference_within(part_[k], grown(part_[k - 1], o_.lean_mm, lean_tolerance_mm_), 0);
    if (out.empty()) return out;
    // Grows back to the carrying area within the layer; the seam is added afterwards. In one step (lean and
    // seam, within the seam of the layer) a greater lean would extend around the corners of the overhang and
    // add more area than a smaller one.
    return grown(intersection_within(grown(out, o_.lean_mm, lean_tolerance_mm_), part_[k], 0), o_.seam_mm,
                 fine_mm_);
  }

  geometry::Region below(const geometry::Region& need, std::size_t k, const geometry::Region& begins) const {
    const geometry::Region left = difference_within(need, part_[k], slack_);
    return left.empty() ? begins : begins.empty() ? left : union_within(left, begins, slack_);
  }

 private:
  std::span<const geometry::Region> part_;
  OverhangOptions o_;
  std::int32_t slack_;
  double lean_tolerance_mm_, fine_mm_;
};

}  // namespace

void for_overhanging(std::span<const geometry::Region> part, const OverhangOptions& options,
                     const ParallelFor& parallel,
                     const std::function<void(std::size_t k, const geometry::Region& need)>& use) {
  const Steps steps(part, options);
  const std::size_t layers = part.empty() ? 0 : part.size() - 1;  // the top layer has no layer above
  std::vector<geometry::Region> ahead, here, needs, before;
  geometry::Region need;
  // Three blocks at a time: one whose overhangs are computed, one through which the area is carried down, one
  // that is used.
  const auto in_block = [&](std::size_t block) { return std::min(layers, block * kLayersOfBlock); };
  for (std::size_t block = 0; block < layers / kLayersOfBlock + 3; ++block) {
    std::swap(ahead, here);
    std::swap(needs, before);
    const std::size_t above = block >= 1 ? layers - in_block(block - 1) : 0;
    const std::size_t first = in_block(block), end = in_block(block + 1);
    ahead.assign(end - first, {});
    const std::size_t used = block >= 2 ? in_block(block - 2) : 0;
    parallel(1 + int(ahead.size() + before.size()), [&](int n) {
      if (n == 0) {
        needs.clear();
        for (std::size_t i = 0; i < here.size(); ++i)
          needs.push_back(need = steps.below(need, above - i, here[i]));
      } else if (std::size_t(n) <= ahead.size()) {
        ahead[std::size_t(n) - 1] = steps.begins(layers - (first + std::size_t(n) - 1));
      } else {
        const std::size_t i = std::size_t(n) - 1 - ahead.size();
        use(layers - 1 - (used + i), before[i]);
      }
    });
  }
}

}  // namespace firn::slice
