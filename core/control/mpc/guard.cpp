#include "core/control/mpc/guard.h"

#include <algorithm>

#include "core/control/prediction.h"

namespace firn::control::mpc {

double useful_share(const Setup& s, const HeightMap& height, const DropletPattern& drops,
                    const MaterialMap& materials) {
  const HeightMap after = Predictor(s).after(height, drops, materials);
  double fallen = 0.0, risen = 0.0;
  for (std::size_t c = 0; c < height.size(); ++c) {
    if (!s.mask.cells[c]) continue;
    const double missing = s.target.cells[c] - height.cells[c];
    fallen += std::max(0.0, missing) - std::max(0.0, s.target.cells[c] - after.cells[c]);
    risen += after.cells[c] - height.cells[c];
  }
  return risen > 0.0 ? fallen / risen : 0.0;
}

}  // namespace firn::control::mpc
