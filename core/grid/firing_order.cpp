#include "core/grid/firing_order.h"

namespace firn {

std::vector<std::uint32_t> firing_order(const DropletPattern& pattern, int pass) {
  std::vector<std::uint32_t> order;
  const GridSpec& s = pattern.spec;
  for (int j = 0; j < s.ny; ++j)
    for (int n = 0; n < s.nx; ++n) {
      const int i = towards_plus_x(j) ? n : s.nx - 1 - n;
      if (pattern.at(i, j) > pass) order.push_back(std::uint32_t(s.index(i, j)));
    }
  return order;
}

}  // namespace firn
