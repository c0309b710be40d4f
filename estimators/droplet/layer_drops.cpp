#include "estimators/droplet/layer_drops.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/grid/firing_order.h"

namespace firn::droplet {
namespace {

constexpr double kMinCountedShare = 0.9;  // below, the count itself is in doubt

}  // namespace

void LayerDrops::add(const PassReport& r) {
  const DropletPattern& commanded = r.commanded;
  const auto order = firing_order(commanded, 0, r.placement);
  const std::size_t n = order.size();
  const std::size_t known = std::min(n, std::size_t(r.unknown_from)),
                    doubt_to = std::min(n, std::size_t(r.unknown_to));
  Pass pass;
  pass.cells.assign(order.begin(), order.begin() + std::ptrdiff_t(known));
  std::sort(pass.cells.begin(), pass.cells.end());
  std::size_t doubt_from = known, doubt_end = doubt_to;
  if (doubt_to == known && known == n && known > 0 && r.triggered_jet >= 0 &&
      std::size_t(r.triggered_jet) < known) {
    pass.share = double(r.triggered_jet) / double(known);
    if (pass.share < kMinCountedShare) {
      doubt_from = 0;
      doubt_end = n;
    }
  }
  for (std::size_t k = doubt_from; k < doubt_end; ++k) {
    doubt_.resize(commanded.size(), 0);
    const int i = int(order[k] % std::size_t(commanded.spec.nx)),
              j = int(order[k] / std::size_t(commanded.spec.nx));
    for (int y = j - 1; y <= j + 1; ++y)
      for (int x = i - 1; x <= i + 1; ++x)
        if (commanded.spec.contains(x, y)) doubt_[commanded.spec.index(x, y)] = 1;
  }
  if (doubt_from == 0 && doubt_end == n) {
    pass.cells.clear();
    pass.share = 1.0;
  }
  if (!pass.cells.empty()) passes_.push_back(std::move(pass));
  // After a doubt the layer is closed; else its last pass, fired to its end, closes it.
  complete_ = doubt_to > known || (known == n && r.pass + 1 >= r.passes);
}

std::vector<Use> LayerDrops::use_of(const HeightMap& height, std::span<const std::int8_t> quality,
                                    const Mask& mask) const {
  std::vector<Use> use(height.size(), Use::kNothing);
  for (std::size_t c = 0; c < use.size(); ++c) {
    if (quality[c] != 0 || !std::isfinite(height.cells[c])) continue;
    use[c] = !mask.cells[c] || (!doubt_.empty() && doubt_[c]) ? Use::kAnchor : Use::kLearn;
  }
  return use;
}

}  // namespace firn::droplet
